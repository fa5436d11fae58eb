// The bytes of an input of fuzz_type_description are:
//
//   u16 bytes of the description (little-endian) | the description | and, if that is one, a mask | a body
//
// The mask is a bit set with as many bytes as the type's leaves need. It need not be closed.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "sft/mask.h"

namespace sft::test {

struct DescriptionInput {
  std::span<const std::byte> description{};
  std::span<const std::byte> rest{};
};

/// Parses the input. A description that is too short ends with the input.
DescriptionInput parse_description_input(std::span<const std::byte> input);

/// Reads a mask from the beginning of `rest`, and removes its bytes there. Missing bytes are zero.
FieldMask take_mask(std::span<const std::byte>& rest, std::size_t leaves);

std::vector<std::byte> make_description_input(std::span<const std::byte> description, const FieldMask& mask,
                                              std::span<const std::byte> body);

}  // namespace sft::test
