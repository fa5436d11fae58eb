// A second, simple implementation of the encodings that SFT converts when it receives them. This
// implementation follows XTypes 1.3, 7.4.3, and uses nothing of the runtime except the type tables.
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
  std::uint16_t code;  ///< the first two bytes of the encapsulation
  std::endian byte_order;
  bool is_xcdr2;
};

inline constexpr ForeignEncoding cdr_le{"CDR_LE", 0x0001, std::endian::little, false};
inline constexpr ForeignEncoding cdr_be{"CDR_BE", 0x0000, std::endian::big, false};
inline constexpr ForeignEncoding cdr2_le{"CDR2_LE", 0x0007, std::endian::little, true};
inline constexpr ForeignEncoding cdr2_be{"CDR2_BE", 0x0006, std::endian::big, true};

/// Returns all encodings. Plain XCDR2 is listed once for each of its codes.
std::span<const ForeignEncoding> foreign_encodings();

void PrintTo(const ForeignEncoding& encoding, std::ostream* out);

/// Returns the encoded body without encapsulation.
std::vector<std::byte> foreign_cdr(const OwnedValue& value, const ForeignEncoding& encoding);

/// Returns the encapsulation, the body, and padding up to a multiple of 4. The encapsulation gives the number
/// of padding bytes.
std::vector<std::byte> foreign_payload(std::span<const std::byte> body, const ForeignEncoding& encoding);

}  // namespace sft::test
