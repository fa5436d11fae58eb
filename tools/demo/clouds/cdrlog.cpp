#include "tools/demo/clouds/file_formats.h"

#include <fmt/format.h>

#include <cstring>

namespace sft::demo {

namespace {
constexpr std::size_t record_header_bytes = 12;
constexpr std::size_t record_length_at = 8;
}  // namespace

Result<std::vector<InputCloud>> read_cdr(std::span<const std::byte> file, std::size_t /*limit*/) {
  return check_payload(file).map(
      [](InputCloud&& cloud) { return std::vector<InputCloud>{std::move(cloud)}; });
}

Result<std::vector<InputCloud>> read_cdrlog(std::span<const std::byte> file, std::size_t limit) {
  std::vector<InputCloud> clouds;
  while (!file.empty() && clouds.size() < limit) {
    const std::size_t number = clouds.size() + 1;
    std::uint32_t length = 0;
    if (file.size() >= record_header_bytes)
      std::memcpy(&length, file.data() + record_length_at, sizeof length);
    if (file.size() < record_header_bytes || file.size() - record_header_bytes < length) {
      return fail(Errc::malformed, fmt::format("it ends in the middle of record {}: truncated?", number));
    }
    Result<InputCloud> cloud = check_payload(file.subspan(record_header_bytes, length));
    if (!cloud) return fail(cloud.error().code, fmt::format("record {}: {}", number, cloud.error().message));
    clouds.emplace_back(std::move(*cloud));
    file = file.subspan(record_header_bytes + length);
  }
  if (clouds.empty()) return fail(Errc::malformed, "there is no record in it");
  return clouds;
}

}  // namespace sft::demo
