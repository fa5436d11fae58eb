// Functions that damage honest datagrams, like a bad network or an attacker.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <random>
#include <vector>

namespace sft::udp::test {

/// Flips a bit, writes an extreme value, or cuts off the end of the datagram. Flipped bits and extreme values
/// are mostly in the header.
template <class Random>
void mutate_once(std::vector<std::byte>& datagram, Random& random) {
  if (datagram.empty()) return;
  const auto below = [&](std::uint64_t end) {
    return std::uniform_int_distribution<std::uint64_t>(0, end - 1)(random);
  };
  const std::size_t header = std::min<std::size_t>(datagram.size(), below(8) == 0 ? datagram.size() : 64);
  const std::uint64_t what = below(10);
  if (what < 5) {
    datagram[below(header)] ^= static_cast<std::byte>(1U << below(8));
  } else if (what < 9) {
    constexpr std::uint64_t values[] = {0,
                                        1,
                                        0x7fff,
                                        0xffff,
                                        0x1'0000,
                                        0x7fff'ffff,
                                        0x8000'0000,
                                        0xffff'ffff,
                                        std::uint64_t{1} << 62,
                                        (std::uint64_t{1} << 62) - 1,
                                        std::uint64_t{1} << 63,
                                        UINT64_MAX};
    const std::uint64_t value = values[below(std::size(values))];
    const std::size_t width = std::size_t{1} << below(4);
    // most headers have their numbers at multiples of the number's width
    const std::size_t step = below(2) == 0 ? 1 : width;
    const std::size_t at = below(header) / step * step;
    for (std::size_t i = 0; i < width && at + i < datagram.size(); ++i)
      datagram[at + i] = static_cast<std::byte>(value >> (8 * i));
  } else {
    datagram.resize(below(datagram.size()) + 1);
  }
}

/// Makes one to three changes to the datagram.
template <class Random>
void mutate(std::vector<std::byte>& datagram, Random& random) {
  for (auto left = std::uniform_int_distribution<int>(1, 3)(random); left > 0; --left)
    mutate_once(datagram, random);
}

}  // namespace sft::udp::test
