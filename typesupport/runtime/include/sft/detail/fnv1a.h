// FNV-1a, 64 bits: http://www.isthe.com/chongo/tech/comp/fnv/. Results are the same on every machine and in
// every build.
#pragma once

#include <cstdint>
#include <string_view>

namespace sft::detail {

class Fnv1a {
 public:
  constexpr void add(std::uint64_t value) {
    for (int byte = 0; byte < 8; ++byte) mix(static_cast<std::uint8_t>(value >> (8 * byte)));
  }
  constexpr void add(std::string_view text) {
    add(text.size());
    for (const char c : text) mix(static_cast<std::uint8_t>(c));
  }
  constexpr std::uint64_t value() const { return hash_; }

 private:
  constexpr void mix(std::uint8_t byte) { hash_ = (hash_ ^ byte) * 0x100000001b3; }

  std::uint64_t hash_ = 0xcbf29ce484222325;
};

}  // namespace sft::detail
