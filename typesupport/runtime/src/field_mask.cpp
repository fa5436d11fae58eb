#include "sft/mask.h"

#include <algorithm>
#include <bit>
#include <cassert>

#include "sft/detail/fnv1a.h"

namespace sft {

using namespace detail;

namespace {

/// Returns the bits of word `i` that are within [first, first + count).
std::uint64_t bits_within(std::size_t i, std::size_t first, std::size_t count) {
  const std::size_t begin = std::max(first, i * 64);
  const std::size_t end = std::min(first + count, (i + 1) * 64);
  if (begin >= end) return 0;
  const std::uint64_t ones = end - begin == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << (end - begin)) - 1;
  return ones << (begin % 64);
}

}  // namespace

FieldMask FieldMask::full(std::size_t leaves) {
  FieldMask m(leaves);
  for (std::size_t i = 0; i < m.words(); ++i) m.mutable_word(i) = bits_within(i, 0, leaves);
  return m;
}

FieldMask FieldMask::from_words(std::size_t leaves, std::span<const std::uint64_t> words) {
  FieldMask m(leaves);
  for (std::size_t i = 0; i < std::min(m.words(), words.size()); ++i)
    m.mutable_word(i) = words[i] & bits_within(i, 0, leaves);
  return m;
}

std::vector<std::uint64_t> FieldMask::to_words() const {
  std::vector<std::uint64_t> words{first_};
  words.insert(words.end(), more_.begin(), more_.end());
  return words;
}

bool FieldMask::contains(const FieldMask& other) const {
  assert(leaves_ == other.leaves_);
  for (std::size_t i = 0; i < words(); ++i) {
    if ((other.word(i) & ~word(i)) != 0) return false;
  }
  return true;
}

bool FieldMask::intersects(const FieldMask& other) const {
  assert(leaves_ == other.leaves_);
  for (std::size_t i = 0; i < words(); ++i) {
    if ((other.word(i) & word(i)) != 0) return true;
  }
  return false;
}

bool FieldMask::any_of_words(std::size_t first, std::size_t count) const {
  for (std::size_t i = first / 64; i * 64 < first + count; ++i) {
    if ((word(i) & bits_within(i, first, count)) != 0) return true;
  }
  return false;
}

bool FieldMask::all_of_words(std::size_t first, std::size_t count) const {
  for (std::size_t i = first / 64; i * 64 < first + count; ++i) {
    const std::uint64_t wanted = bits_within(i, first, count);
    if ((word(i) & wanted) != wanted) return false;
  }
  return true;
}

std::size_t FieldMask::next(std::size_t first, std::size_t end) const noexcept {
  if (first >= end) return end;
  std::uint64_t left = word(first / 64) >> (first % 64);
  if (left != 0) return std::min(end, first + static_cast<std::size_t>(std::countr_zero(left)));
  for (std::size_t i = first / 64 + 1; i * 64 < end; ++i) {
    left = word(i);
    if (left != 0) return std::min(end, i * 64 + static_cast<std::size_t>(std::countr_zero(left)));
  }
  return end;
}

bool FieldMask::empty() const {
  return first_ == 0 && std::all_of(more_.begin(), more_.end(), [](std::uint64_t w) { return w == 0; });
}

std::size_t FieldMask::size() const {
  std::size_t n = static_cast<std::size_t>(std::popcount(first_));
  for (const std::uint64_t w : more_) n += static_cast<std::size_t>(std::popcount(w));
  return n;
}

template <class Combine>
FieldMask& FieldMask::combine(const FieldMask& other, Combine combine) {
  assert(leaves_ == other.leaves_);
  for (std::size_t i = 0; i < words(); ++i) mutable_word(i) = combine(word(i), other.word(i));
  return *this;
}

FieldMask& FieldMask::operator|=(const FieldMask& other) { return combine(other, std::bit_or{}); }

FieldMask& FieldMask::operator&=(const FieldMask& other) { return combine(other, std::bit_and{}); }

FieldMask& FieldMask::operator^=(const FieldMask& other) { return combine(other, std::bit_xor{}); }

FieldMask& FieldMask::operator-=(const FieldMask& other) {
  return combine(other, [](std::uint64_t a, std::uint64_t b) { return a & ~b; });
}

std::uint64_t FieldMask::hash() const {
  if (more_.empty()) return first_;
  Fnv1a hash;
  for (std::size_t i = 0; i < words(); ++i) hash.add(word(i));
  return hash.value();
}

}  // namespace sft
