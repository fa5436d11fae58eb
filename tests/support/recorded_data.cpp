#include "tests/support/recorded_data.h"

#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>

namespace sft::test {

namespace {

std::optional<Payload> unpacked(const std::filesystem::path& file) {
  if (std::system("command -v xz >/dev/null") != 0) return std::nullopt;
  const std::string command = "xz -dc -- '" + file.string() + "'";
  std::FILE* pipe = ::popen(command.c_str(), "r");
  if (pipe == nullptr) throw std::runtime_error("cannot run " + command);
  Payload payload;
  std::array<std::byte, 65'536> piece;
  while (const std::size_t n = std::fread(piece.data(), 1, piece.size(), pipe)) {
    payload.insert(payload.end(), piece.begin(), piece.begin() + static_cast<std::ptrdiff_t>(n));
  }
  if (::pclose(pipe) != 0) throw std::runtime_error(command + " failed");
  return payload;
}

}  // namespace

std::filesystem::path recorded_data() { return SFT_TEST_DATA_DIR; }

std::optional<Payload> read_recording(const std::filesystem::path& file) {
  if (file.extension() == ".xz") return unpacked(file);
  std::ifstream stream(file, std::ios::binary);
  const std::string text(std::istreambuf_iterator<char>(stream), {});
  if (!stream) throw std::runtime_error("cannot read " + file.string());
  const auto* first = reinterpret_cast<const std::byte*>(text.data());
  return Payload(first, first + text.size());
}

std::vector<Payload> read_records(const std::filesystem::path& file) {
  constexpr std::size_t header_bytes = 12;
  const Payload log = read_recording(file).value();
  std::vector<Payload> records;
  for (std::size_t at = 0; at + header_bytes <= log.size();) {
    std::uint32_t bytes;
    std::memcpy(&bytes, log.data() + at + 8, sizeof bytes);
    at += header_bytes;
    if (bytes > log.size() - at) throw std::runtime_error(file.string() + " ends within a record");
    const auto first = log.begin() + static_cast<std::ptrdiff_t>(at);
    records.emplace_back(first, first + bytes);
    at += bytes;
  }
  return records;
}

}  // namespace sft::test
