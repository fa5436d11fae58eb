// The bytes of an input of fuzz_type_description are:
//
//   u16 bytes of the description (little-endian) | the description | a mask | a body
//
// If the description is invalid, the mask and the body do not count. The mask is a bit set with as many
// bytes as the type's leaves need, and need not be closed.
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

/// Returns the mask at the beginning of `rest`, and removes the mask's bytes from `rest`. Missing bytes count
/// as zero.
FieldMask take_mask(std::span<const std::byte>& rest, std::size_t leaves);

std::vector<std::byte> make_description_input(std::span<const std::byte> description, const FieldMask& mask,
                                              std::span<const std::byte> body);

}  // namespace sft::test
