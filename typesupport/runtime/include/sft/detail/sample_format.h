// The layout of one encoded sample in memory, the same in a shared chunk and in a heap buffer:
//
//   SampleHeader | u32 offset per slot | padding | 4 bytes of encapsulation | CDR body
//
// The body is 8-aligned in memory, so that every primitive has the alignment of CDR. The body is byte for
// byte what DDS writes (XCDR1, little-endian) for the type projected to the sample's mask. Offsets count
// from the first byte of the body. The offset of a string or a sequence is that of its length. A slot whose
// leaves are absent has the value no_offset.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace sft::detail {

inline constexpr std::uint32_t no_offset = 0xFFFF'FFFF;
inline constexpr std::uint32_t sample_magic = 0x31544653;  // the bytes "SFT1"
inline constexpr std::size_t encapsulation_bytes = 4;
inline constexpr std::array<std::uint8_t, encapsulation_bytes> encapsulation_cdr_le{0x00, 0x01, 0x00, 0x00};

struct SampleHeader {
  std::uint32_t magic = sample_magic;
  std::uint16_t index_slots = 0;
  /// The number of gates in the table that follows the body (core/seam/gate_table.h).
  std::uint16_t gates = 0;
  std::uint64_t writer = 0;          ///< the writer's random id, which is different after a restart
  std::uint64_t sequence = 0;        ///< number of the sample, counted from 1
  std::int64_t source_stamp_ns = 0;  ///< CLOCK_REALTIME when the sample was published
  std::uint64_t type_hash = 0;
  std::uint32_t body_offset = 0;  ///< the offset of the body from the header's first byte
  std::uint32_t body_bytes = 0;
  // Sequence and stamp of the newest earlier sample of the writer that was sent only by UDP, because shared
  // memory was not in use yet or could not take the sample. That sample may arrive later than this sample.
  // 0: there is no such sample.
  std::uint64_t diverted_sequence = 0;
  std::int64_t diverted_stamp_ns = 0;
};
static_assert(sizeof(SampleHeader) == 64);

/// The positions of the parts of a sample, counted from the header, for a type with that many slots.
struct SampleLayout {
  std::size_t body_offset;

  explicit constexpr SampleLayout(std::size_t index_slots)
      : body_offset((sizeof(SampleHeader) + index_slots * sizeof(std::uint32_t) + encapsulation_bytes + 7) /
                    8 * 8) {}

  constexpr std::size_t bytes(std::size_t body_bytes) const { return body_offset + body_bytes; }
};

}  // namespace sft::detail
