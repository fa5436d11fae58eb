// Payloads in the encodings that are converted on entry, written a second time and in the plainest way from
// the sentences of XTypes 1.3, 7.4.3: nothing of the runtime is used but the tables.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <iosfwd>
#include <span>
#include <vector>

#include "tests/support/owned_value.h"

namespace sft::test {

struct ForeignEncoding {
  const char* name;
  std::uint16_t code;  ///< first two bytes of the encapsulation
  std::endian byte_order;
  bool is_xcdr2;
};

inline constexpr ForeignEncoding cdr_le{"CDR_LE", 0x0001, std::endian::little, false};
inline constexpr ForeignEncoding cdr_be{"CDR_BE", 0x0000, std::endian::big, false};
inline constexpr ForeignEncoding cdr2_le{"CDR2_LE", 0x0007, std::endian::little, true};
inline constexpr ForeignEncoding cdr2_be{"CDR2_BE", 0x0006, std::endian::big, true};

/// All of them, and plain XCDR2 under its other numbers.
std::span<const ForeignEncoding> foreign_encodings();

void PrintTo(const ForeignEncoding& encoding, std::ostream* out);

/// The body alone.
std::vector<std::byte> foreign_cdr(const OwnedValue& value, const ForeignEncoding& encoding);

/// Encapsulation, body, and as many bytes of padding as the encapsulation announces: up to a multiple of 4.
std::vector<std::byte> foreign_payload(std::span<const std::byte> body, const ForeignEncoding& encoding);

}  // namespace sft::test
