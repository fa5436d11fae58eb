// The headers of SFT datagrams (datagram.md): from structs to bytes and back. Pure and bounds-checked.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace sft::udp {

inline constexpr std::uint8_t wire_version = 1;
inline constexpr std::size_t first_header_bytes = 32;
inline constexpr std::size_t following_header_bytes = 16;
inline constexpr std::size_t datagram_bytes_max = 65507;  ///< of a UDP payload over IPv4
inline constexpr std::size_t datagram_bytes_min = 548;    ///< what every IPv4 path takes

enum class DatagramKind : std::uint8_t {
  first = 1,      ///< begins a sample
  following = 2,  ///< a later part of its body
};

/// Flags of a first datagram. Its mask field is a hash, and the mask's words stand right before the payload.
inline constexpr std::uint8_t mask_words_follow = 1;
/// The sample passed a gate for a maximum rate: `rate` stands right behind the header.
inline constexpr std::uint8_t rate_follows = 2;
inline constexpr std::size_t rate_bytes = 8;
/// The sample is for one late reader only: `history` stands behind that.
inline constexpr std::uint8_t history_follows = 4;
inline constexpr std::size_t history_bytes = 16;

/// Names one encoding of one sample. Equal in all its datagrams, and different in all others for a long time.
struct SampleLabel {
  std::uint32_t writer = 0;    ///< low half of the writer's id
  std::uint32_t sequence = 0;  ///< low half of the sequence
  std::uint16_t variant = 0;   ///< the writer's number for the mask
  friend bool operator==(const SampleLabel&, const SampleLabel&) = default;
};

/// The gate that a sample passed at its writer (core/rate_gate.h), as the how-manieth.
struct RateMark {
  std::uint32_t min_period_us = 0;
  std::uint32_t ordinal = 0;
  friend bool operator==(const RateMark&, const RateMark&) = default;
};

/// A sample of those that begin with what was retained.
struct HistoryMark {
  std::uint64_t reader = 0;  ///< its id
  std::uint64_t oldest = 0;  ///< sequence of the first sample that it is sent
  friend bool operator==(const HistoryMark&, const HistoryMark&) = default;
};

struct FirstHeader {
  SampleLabel label;
  std::uint8_t flags = 0;
  std::uint32_t total = 0;    ///< bytes of the body, without encapsulation
  std::uint64_t mask = 0;     ///< leaf bits, or FieldMask::hash() where there are more than 64 leaves
  std::int64_t stamp_ns = 0;  ///< CLOCK_REALTIME at publish
  RateMark rate{};            ///< where the flag says so
  HistoryMark history{};      ///< likewise

  /// With what the flags say follows it, but for the mask's words.
  std::size_t bytes() const { return at_history() + ((flags & history_follows) != 0 ? history_bytes : 0); }
  std::size_t at_history() const {
    return first_header_bytes + ((flags & rate_follows) != 0 ? rate_bytes : 0);
  }
};

struct FollowingHeader {
  SampleLabel label;
  std::uint32_t offset = 0;  ///< of the payload in the body
};

void encode(const FirstHeader& header, std::byte* out) noexcept;      ///< header.bytes()
void encode(const FollowingHeader& header, std::byte* out) noexcept;  ///< following_header_bytes

/// A received datagram whose header is sound. What it says of the sample is only claimed.
struct Datagram {
  DatagramKind kind{};
  FirstHeader first;                   ///< of a following datagram only the label is set
  std::uint32_t offset = 0;            ///< of the payload in the body; 0 in a first datagram
  std::span<const std::byte> payload;  ///< begins with the mask's words where the flag says so

  const SampleLabel& label() const { return first.label; }
};

/// Empty if the bytes are no datagram of this version.
std::optional<Datagram> parse(std::span<const std::byte> bytes) noexcept;

void store_word(std::uint64_t word, std::byte* out) noexcept;
std::uint64_t load_word(const std::byte* from) noexcept;

/// The 64-bit sequence nearest to `reference` that has these low 32 bits; never below zero.
std::uint64_t widen_sequence(std::uint64_t reference, std::uint32_t low) noexcept;

}  // namespace sft::udp
