// The bytes of an input of fuzz_decoder are:
//
//   u16 number of the type among every_type() (modulo their count) | its mask | the mask to project to | the
//   body
//
// Masks are bit sets with as many bytes as the type's leaves need. They need not be closed. Only those
// leaves of the second mask count that are in the first one.
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
  FieldMask mask{};                   ///< a closed field mask
  FieldMask narrower{};               ///< closed, a subset of mask
  std::span<const std::byte> body{};  ///< within the input, not aligned
};

/// Returns nothing if the input ends before the body.
std::optional<DecoderInput> parse_decoder_input(std::span<const std::byte> input);

std::vector<std::byte> make_decoder_input(std::size_t type, const FieldMask& mask, const FieldMask& narrower,
                                          std::span<const std::byte> body);

}  // namespace sft::test
