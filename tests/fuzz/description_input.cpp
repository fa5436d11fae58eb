#include "tests/fuzz/description_input.h"

#include <algorithm>

namespace sft::test {

DescriptionInput parse_description_input(std::span<const std::byte> input) {
  if (input.size() < 2) return {};
  const auto announced = std::to_integer<std::size_t>(input[0]) | std::to_integer<std::size_t>(input[1]) << 8;
  input = input.subspan(2);
  const std::size_t bytes = std::min(announced, input.size());
  return {input.first(bytes), input.subspan(bytes)};
}

FieldMask take_mask(std::span<const std::byte>& rest, std::size_t leaves) {
  FieldMask mask(leaves);
  const std::size_t bytes = std::min(rest.size(), (leaves + 7) / 8);
  for (std::size_t leaf = 0; leaf < std::min(leaves, bytes * 8); ++leaf) {
    if ((std::to_integer<unsigned>(rest[leaf / 8]) >> (leaf % 8) & 1) != 0) mask.insert(leaf);
  }
  rest = rest.subspan(bytes);
  return mask;
}

std::vector<std::byte> make_description_input(std::span<const std::byte> description, const FieldMask& mask,
                                              std::span<const std::byte> body) {
  std::vector<std::byte> input;
  input.reserve(2 + description.size() + body.size());
  for (const int shift : {0, 8}) input.push_back(static_cast<std::byte>(description.size() >> shift));
  input.insert(input.end(), description.begin(), description.end());
  for (std::size_t i = 0; i < (mask.leaves() + 7) / 8; ++i)
    input.push_back(static_cast<std::byte>(mask.word(i / 8) >> (i % 8 * 8)));
  input.insert(input.end(), body.begin(), body.end());
  return input;
}

}  // namespace sft::test
