// SipHash-2-4, a hash function with a key. Its values cannot be predicted without the key. With the same
// key, equal words have equal hashes.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <span>

namespace sft::udp {

using HashKey = std::array<std::uint64_t, 2>;

inline std::uint64_t keyed_hash(const HashKey& key, std::span<const std::uint64_t> words) noexcept {
  std::array<std::uint64_t, 4> v{key[0] ^ 0x736f6d6570736575, key[1] ^ 0x646f72616e646f6d,
                                 key[0] ^ 0x6c7967656e657261, key[1] ^ 0x7465646279746573};
  const auto mix = [&v](int rounds) {
    for (; rounds > 0; --rounds) {
      v[0] += v[1], v[2] += v[3];
      v[1] = std::rotl(v[1], 13) ^ v[0], v[3] = std::rotl(v[3], 16) ^ v[2];
      v[0] = std::rotl(v[0], 32);
      v[2] += v[1], v[0] += v[3];
      v[1] = std::rotl(v[1], 17) ^ v[2], v[3] = std::rotl(v[3], 21) ^ v[0];
      v[2] = std::rotl(v[2], 32);
    }
  };
  const auto take = [&](std::uint64_t word) {
    v[3] ^= word;
    mix(2);
    v[0] ^= word;
  };
  for (const std::uint64_t word : words) take(word);
  // The highest byte of the last word is the length in bytes, modulo 256.
  take(std::uint64_t{words.size()} << 59);
  v[2] ^= 0xff;
  mix(4);
  return v[0] ^ v[1] ^ v[2] ^ v[3];
}

}  // namespace sft::udp
