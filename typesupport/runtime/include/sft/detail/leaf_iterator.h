// Iterates over the members of a set of leaves, in ascending order.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <iterator>

namespace sft::detail {

/// Set has word_count() words word(i), in which bit b stands for leaf 64 * i + b. The iterator refers to
/// the set, which must not change during the iteration.
template <class Set>
class LeafIterator {
 public:
  using iterator_concept = std::forward_iterator_tag;
  // The highest category that C++17 allows if elements are values.
  using iterator_category = std::input_iterator_tag;
  using value_type = std::size_t;
  using reference = std::size_t;
  using pointer = void;
  using difference_type = std::ptrdiff_t;

  constexpr LeafIterator() = default;
  static constexpr LeafIterator first(const Set& set) {
    LeafIterator i(set, 0, set.word(0));
    i.skip_empty_words();
    return i;
  }
  static constexpr LeafIterator end(const Set& set) { return LeafIterator(set, set.word_count(), 0); }

  constexpr std::size_t operator*() const {
    return word_ * 64 + static_cast<std::size_t>(std::countr_zero(bits_));
  }
  constexpr LeafIterator& operator++() {
    bits_ &= bits_ - 1;
    skip_empty_words();
    return *this;
  }
  constexpr LeafIterator operator++(int) {
    LeafIterator before = *this;
    ++*this;
    return before;
  }
  friend constexpr bool operator==(const LeafIterator& a, const LeafIterator& b) {
    return a.word_ == b.word_ && a.bits_ == b.bits_;
  }

 private:
  constexpr LeafIterator(const Set& set, std::size_t word, std::uint64_t bits)
      : set_(&set), word_(word), bits_(bits) {}

  constexpr void skip_empty_words() {
    while (bits_ == 0 && ++word_ < set_->word_count()) bits_ = set_->word(word_);
  }

  const Set* set_ = nullptr;
  std::size_t word_ = 0;
  std::uint64_t bits_ = 0;  ///< the bits of the present word that are not yet visited
};

}  // namespace sft::detail
