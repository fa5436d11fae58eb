// Little-endian numbers, and texts after their lengths, in the form that records of MCAP have.
#pragma once

#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sft::recording {

static_assert(std::endian::native == std::endian::little);

using Bytes = std::vector<std::byte>;
using Texts = std::map<std::string, std::string>;

/// Returns the value of the key; empty if the key is missing.
inline std::string value_of(const Texts& texts, const char* key) {
  const auto found = texts.find(key);
  return found == texts.end() ? std::string() : found->second;
}

inline std::span<const std::byte> bytes_of(std::string_view text) { return std::as_bytes(std::span(text)); }

/// Appends numbers and texts to a buffer, which must outlive this object.
class ByteWriter {
 public:
  explicit ByteWriter(Bytes& to) : to_(to) {}

  template <std::integral I>
  void number(I value) {
    const auto bytes = std::as_bytes(std::span(&value, 1));
    raw(bytes);
  }
  void raw(std::span<const std::byte> bytes) { to_.insert(to_.end(), bytes.begin(), bytes.end()); }
  void text(std::string_view text) {
    number(static_cast<std::uint32_t>(text.size()));
    raw(bytes_of(text));
  }
  void texts(const Texts& map) {
    const std::size_t length = begin_length<std::uint32_t>();
    for (const auto& [key, value] : map) {
      text(key);
      text(value);
    }
    end_length<std::uint32_t>(length);
  }
  /// Leaves space for the length of the bytes that follow, and returns the position of this space.
  template <std::integral I>
  std::size_t begin_length() {
    number(I{0});
    return to_.size();
  }
  template <std::integral I>
  void end_length(std::size_t begin) {
    const auto length = static_cast<I>(to_.size() - begin);
    std::memcpy(to_.data() + begin - sizeof(I), &length, sizeof(I));
  }

 private:
  Bytes& to_;
};

/// Reads from a span that may end too early or contradict itself. After the first fault, all results are
/// zero or empty, and is_good() returns false.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::byte> from) : from_(from) {}

  bool is_good() const { return good_; }
  bool at_end() const { return from_.empty(); }
  std::size_t left() const { return from_.size(); }

  template <std::integral I>
  I number() {
    I value{};
    const auto bytes = raw(sizeof(I));
    if (bytes.size() == sizeof(I)) std::memcpy(&value, bytes.data(), sizeof(I));
    return value;
  }
  std::span<const std::byte> raw(std::uint64_t length) {
    if (length > from_.size()) {
      good_ = false;
      from_ = {};
      return {};
    }
    const auto bytes = from_.first(static_cast<std::size_t>(length));
    from_ = from_.subspan(bytes.size());
    return bytes;
  }
  std::string_view text() {
    const auto bytes = raw(number<std::uint32_t>());
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  }
  Texts texts() {
    Texts map;
    ByteReader entries(raw(number<std::uint32_t>()));
    while (!entries.at_end() && entries.is_good()) {
      std::string key(entries.text());
      map[std::move(key)] = entries.text();
    }
    good_ = good_ && entries.is_good();
    return map;
  }

 private:
  std::span<const std::byte> from_;
  bool good_ = true;
};

}  // namespace sft::recording
