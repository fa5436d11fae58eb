// All offset and bounds checks for reading CDR are here and in walk.cpp. The bytes may be hostile, and those
// in shared memory may change while they are read. So each length is loaded once, checked, and then used.
#pragma once

#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>

#include "sft/detail/access_log.h"
#include "sft/detail/sample_format.h"
#include "sft/detail/type_table.h"
#include "sft/mask.h"

namespace sft::detail {

/// The maximum number of elements that are made or walked over if only the length of a sequence of structs
/// was sent.
inline constexpr std::uint32_t max_empty_elements = 65'536;

class ElementIndex;
class PartsInPlace;

/// A CDR body under a mask, and the objects with which a reader reads it. Owns nothing.
struct SampleState {
  const std::byte* body = nullptr;  ///< the first byte, aligned to 8
  std::uint32_t body_bytes = 0;
  const std::uint32_t* index = nullptr;  ///< one offset per slot; may be null if the body is only walked over
  const FieldMask* mask = nullptr;       ///< the leaves that are present
  AccessLog* log = nullptr;              ///< the log of reads; null unless the reader records
  ElementIndex* elements = nullptr;      ///< stores the offsets of elements; null: a jump walks over elements
  /// The parts that are outside of the body; null: there are none (parts_in_place.h).
  PartsInPlace* parts = nullptr;
  mutable bool malformed = false;  ///< set if a getter found malformed bytes

  // The flag is accessed atomically, since several threads may read one sample.
  void flag_malformed() const noexcept { __atomic_store_n(&malformed, true, __ATOMIC_RELAXED); }
  bool is_malformed() const noexcept { return __atomic_load_n(&malformed, __ATOMIC_RELAXED); }
};

constexpr std::uint64_t align_up(std::uint64_t offset, std::uint64_t alignment) {
  return (offset + alignment - 1) & ~(alignment - 1);
}

/// Checks that `count` elements of `element_bytes` each lie within the body. They begin at `offset`, rounded
/// up to `alignment`. Returns the offset of the first element, or no_offset if they do not fit. If `count`
/// is 0, `offset` is not rounded up.
inline std::uint32_t checked_block(const SampleState& s, std::uint64_t offset, std::uint64_t count,
                                   std::uint64_t element_bytes, std::uint64_t alignment) noexcept {
  if (count == 0) return offset <= s.body_bytes ? static_cast<std::uint32_t>(offset) : no_offset;
  const std::uint64_t first = align_up(offset, alignment);
  return first + count * element_bytes <= s.body_bytes ? static_cast<std::uint32_t>(first) : no_offset;
}
/// Checks elements that are aligned to their size, as all elements in samples are.
inline std::uint32_t checked_block(const SampleState& s, std::uint64_t offset, std::uint64_t count,
                                   std::uint64_t element_bytes) noexcept {
  return checked_block(s, offset, count, element_bytes, element_bytes);
}

/// Reads exactly once a number that is checked and then used. A compiler assumes that the bytes in memory
/// do not change. So it might read the number again where it is used, after the check. The empty
/// instruction seems to change the number, so that the compiler cannot replace the number by the value in
/// memory.
template <std::integral T>
T read_once(const std::byte* at) noexcept {
  T value;
  std::memcpy(&value, at, sizeof value);
  asm("" : "+r"(value));
  return value;
}

struct Extent {
  std::uint32_t first = no_offset;  ///< offset of the first element
  std::uint32_t count = 0;
  explicit operator bool() const { return first != no_offset; }
};

/// Reads the u32 at `offset`, which must be aligned to 4. Returns the number, and the offset of the first
/// byte after it.
inline Extent checked_length(const SampleState& s, std::uint64_t offset,
                             std::endian byte_order = std::endian::little) noexcept {
  const std::uint32_t at = checked_block(s, offset, 1, 4);
  if (at == no_offset) return {};
  const auto n = read_once<std::uint32_t>(s.body + at);
  return {at + 4, byte_order == std::endian::native ? n : __builtin_bswap32(n)};
}

/// Checks a sequence of primitives whose length is at `offset`.
inline Extent checked_sequence(const SampleState& s, std::uint64_t offset,
                               std::size_t element_bytes) noexcept {
  const Extent length = checked_length(s, offset);
  if (!length) return {};
  return {checked_block(s, length.first, length.count, element_bytes), length.count};
}

/// Returns the bytes of the part that takes the place of that leaf (PartsInPlace); nothing if the body has
/// the leaf. REQUIRES: s.parts is not null.
std::optional<std::span<const std::byte>> bytes_in_place(const SampleState& s, std::size_t leaf) noexcept;

/// Returns the sample with its parts: see PartsInPlace. REQUIRES: s.parts is not null.
const SampleState& put_together(const SampleState& s) noexcept;

/// Notes a read of these leaves if reads are recorded. Returns whether the sample has all of them with
/// their published values. Used for values that are found without the getters of their leaves.
bool note_leaves(const SampleState& s, std::size_t first, std::size_t count);

/// Checks a string whose length (including its NUL) is at `offset`. `count` of the result does not include
/// the NUL. A string of length 0 counts as empty.
inline Extent checked_string(const SampleState& s, std::uint64_t offset) noexcept {
  const Extent length = checked_length(s, offset);
  if (!length || checked_block(s, length.first, length.count, 1) == no_offset) return {};
  return {length.first, length.count == 0 ? 0 : length.count - 1};
}

/// Returns the offset at which a string ends whose length is at `offset`.
inline std::uint32_t skip_string(const SampleState& s, std::uint64_t offset) noexcept {
  const Extent length = checked_length(s, offset);
  return length ? checked_block(s, length.first + std::uint64_t{length.count}, 0, 1) : no_offset;
}

/// Checks contiguous elements of at least `bytes_min` bytes each at `extent`. Returns an extent without
/// elements if the body cannot contain extent.count elements.
inline Extent checked_elements(const SampleState& s, Extent extent, std::uint32_t bytes_min) noexcept {
  if (extent.first > s.body_bytes) return {};
  const bool fits = std::uint64_t{extent.count} * bytes_min <= s.body_bytes - extent.first;
  return fits ? extent : Extent{};
}

/// Skips the selected leaves of a member (or of a whole struct) that begins at `offset`. Returns the offset
/// at which these leaves end, or no_offset if the body ends earlier. `leaf` is the number of the member's
/// first leaf in the root type.
std::uint32_t skip(const SampleState& s, const Member& member, std::size_t leaf,
                   std::uint64_t offset) noexcept;
std::uint32_t skip(const SampleState& s, const StructType& type, std::size_t leaf,
                   std::uint64_t offset) noexcept;

/// Returns the offset at which `n` contiguous structs end, in the same way as skip(). Structs of which
/// nothing is selected take no bytes.
std::uint32_t skip_elements(const SampleState& s, const StructType& type, std::size_t leaf, std::uint32_t n,
                            std::uint64_t offset) noexcept;

/// Returns the offset at which member number `member` of a struct begins, before alignment. The struct
/// begins at `offset`.
std::uint32_t member_begin(const SampleState& s, const StructType& type, std::size_t member, std::size_t leaf,
                           std::uint64_t offset) noexcept;

enum class WalkStatus : std::uint8_t {
  ok,
  truncated,
  bad_length,
  bad_boolean,
  bad_string,
  trailing_bytes,
  bad_delimiter,  ///< a wrong delimiter; only in foreign encodings (convert.h), like the next value
  too_large
};
const char* to_string(WalkStatus status);

/// The maximum number of bytes after the last member of a body. Other implementations pad payloads to a
/// multiple of 4 bytes.
inline constexpr std::uint32_t max_trailing_bytes = 3;

/// Walks a whole body of `type` under `s.mask`, checks it, and writes the offset of every slot to `index`
/// (slot_count(type) entries). The check covers lengths, bounds, booleans (0 or 1), strings (a NUL at the
/// end and none before it), and the bytes after the last member (max_trailing_bytes at most). The time is
/// limited by the number of bytes of the body. If `body_end` is given, it is set to the end of the last
/// member.
WalkStatus build_index(const SampleState& s, const StructType& type, std::span<std::uint32_t> index,
                       std::uint32_t* body_end = nullptr) noexcept;

}  // namespace sft::detail
