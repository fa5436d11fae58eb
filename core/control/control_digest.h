// A digest is one number for all that a node has announced and asked for in one role. It travels with the
// node's signs of life, so that others can tell whether they have heard all of it. Order does not matter: a
// digest is the sum of its parts. So the digest of both roles is the sum of two.
#pragma once

#include <cstdint>

namespace sft::core {

/// Three octets for each role: signs of life have room for so many (sft_control.idl).
inline constexpr std::uint32_t control_digest_max = (1U << 24) - 1;

/// The part of one endpoint: of its newest announcement, and of its newest request if it is a reader.
inline std::uint32_t digest_part(std::uint64_t id, std::uint64_t revision, std::uint64_t request_sequence) {
  std::uint64_t mixed = 0;
  for (const std::uint64_t word : {id, revision, request_sequence}) {
    mixed = (mixed ^ word) * 0x9e3779b97f4a7c15U;  // 2^64 over the golden ratio: spreads each bit
    mixed ^= mixed >> 29;
  }
  return static_cast<std::uint32_t>(mixed >> 40);
}

inline std::uint32_t add_to_digest(std::uint32_t digest, std::uint32_t part) {
  return (digest + part) & control_digest_max;
}

}  // namespace sft::core
