#include "tests/fuzz/decoder_input.h"

namespace sft::test {

namespace {

constexpr std::size_t number_bytes = 2;

std::size_t mask_bytes(const FieldMask& mask) { return (mask.leaves() + 7) / 8; }

void append(std::vector<std::byte>& input, const FieldMask& mask) {
  for (std::size_t i = 0; i < mask_bytes(mask); ++i) {
    input.push_back(static_cast<std::byte>(mask.word(i / 8) >> (i % 8 * 8)));
  }
}

/// Returns the leaves that are in `limit` and in the bit set `bytes`.
FieldMask intersection(std::span<const std::byte> bytes, const FieldMask& limit) {
  FieldMask mask(limit.leaves());
  for (std::size_t leaf = 0; leaf < limit.leaves(); ++leaf) {
    const bool selected = (std::to_integer<unsigned>(bytes[leaf / 8]) >> (leaf % 8) & 1) != 0;
    if (selected && limit.contains(leaf)) mask.insert(leaf);
  }
  return mask;
}

}  // namespace

std::optional<DecoderInput> parse_decoder_input(std::span<const std::byte> input) {
  if (input.size() < number_bytes) return std::nullopt;
  const auto low = std::to_integer<std::size_t>(input[0]), high = std::to_integer<std::size_t>(input[1]);
  const std::size_t number = low | high << 8;
  const MessageType& type = every_type()[number % every_type().size()];
  const TypeSupport& support = *type.support;
  const std::size_t bytes = mask_bytes(support.full());
  input = input.subspan(number_bytes);
  if (input.size() < 2 * bytes) return std::nullopt;
  const FieldMask mask = support.closed(intersection(input.first(bytes), support.full()));
  const FieldMask narrower = support.closed(intersection(input.subspan(bytes, bytes), mask));
  return DecoderInput{&type, mask, narrower, input.subspan(2 * bytes)};
}

std::vector<std::byte> make_decoder_input(std::size_t type, const FieldMask& mask, const FieldMask& narrower,
                                          std::span<const std::byte> body) {
  std::vector<std::byte> input{static_cast<std::byte>(type), static_cast<std::byte>(type >> 8)};
  append(input, mask);
  append(input, narrower);
  input.insert(input.end(), body.begin(), body.end());
  return input;
}

}  // namespace sft::test
