// The bytes of an input of fuzz_decoder are:
//
//   u16 number of the type among every_type() (modulo their count) | its mask | the mask to project to | the
//   body
//
// Masks are bit sets with as many bytes as the type's leaves need, and need not be closed. A leaf of the
// second mask counts only if the first mask has the leaf, too.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "tests/support/message_types.h"

namespace sft::test {

struct DecoderInput {
  const MessageType* type = nullptr;
  FieldMask mask{};                   ///< a closed mask
  FieldMask narrower{};               ///< a closed mask, a subset of `mask`
  std::span<const std::byte> body{};  ///< refers to bytes of the input, which are not aligned
};

/// Parses the input. Returns nothing if the input ends before the body.
std::optional<DecoderInput> parse_decoder_input(std::span<const std::byte> input);

std::vector<std::byte> make_decoder_input(std::size_t type, const FieldMask& mask, const FieldMask& narrower,
                                          std::span<const std::byte> body);

}  // namespace sft::test
