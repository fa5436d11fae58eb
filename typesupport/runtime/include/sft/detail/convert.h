// Converts payloads of other implementations (4 bytes of encapsulation and a body) to the only encoding of
// samples: XCDR1, little-endian. This is done once, when they arrive.
//
//   00 01             XCDR1, little-endian             not converted
//   00 00             XCDR1, big-endian                converted
//   00 07, 00 06      plain XCDR2, little-, big-endian converted
//   00 11, 00 10      the same: XTypes 1.3 numbers it in two ways (tables 60 and 39), and both are in use
//   00 02, 00 03, 00 0a, 00 0b, 00 12, 00 13           parameter lists (mutable types): refused
//   00 08, 00 09, 00 14, 00 15                         delimited XCDR2 (appendable types): refused
//
// XCDR2 aligns values of 8 bytes to 4 bytes. It begins arrays and sequences with a delimiter, which is their
// length in bytes, unless the elements are primitives (enumerations are none). As in Cyclone DDS, nested
// types are read as final, and an array whose element type is itself an array is read as one array.
//
// These rules hold for the contents in every encoding:
//
//   boolean other than 0 and 1                  refused
//   string without NUL, or with one inside      refused
//   string of length 0, not even a NUL          accepted, and not changed
//   delimiter that is not the exact length      refused
//   padding between members                     any bytes; zeros if it is converted
//   bytes after the last member                 as many as the last 2 bits of the encapsulation say, and up
//                                               to 3 more: accepted and dropped
//   address of the payload                      any
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "sft/detail/type_table.h"
#include "sft/detail/walk.h"
#include "sft/result.h"

namespace sft::detail {

/// The body of a payload, and its encoding. Owns nothing.
struct Payload {
  /// The body without announced padding; its address may have any alignment.
  std::span<const std::byte> body;
  std::endian byte_order = std::endian::little;
  bool is_xcdr2 = false;

  bool needs_conversion() const { return is_xcdr2 || byte_order != std::endian::little; }
};

/// Reads the encapsulation. The error names an encoding that is refused, and says what to do.
Result<Payload> parse_payload(std::span<const std::byte> payload);

struct ConvertedSize {
  WalkStatus status = WalkStatus::ok;
  std::uint32_t bytes = 0;
};

/// Returns the size of the body that convert() will write. This is the size of the payload's body if
/// nothing is converted, and at most 3/2 of that size otherwise. Reads only the lengths in the body.
ConvertedSize converted_size(const Payload& payload, const StructType& type) noexcept;

/// Writes the body, exactly converted_size() bytes. The lengths and delimiters in the body are those of the
/// payload, and are checked to lie within the payload. build_index() checks everything else that makes a
/// body valid.
WalkStatus convert(const Payload& payload, const StructType& type, std::span<std::byte> body) noexcept;

}  // namespace sft::detail
