// Getters of several structs or strings return this lazy range with random access, for range-for, `range[i]`,
// and the algorithms and views of std::ranges. It owns nothing: the range and its iterators are valid as long
// as the sample. Elements are values (a View, a std::string_view) that are made when they are read.
//
// A step to the next element reads the bytes of the present element and costs nothing else. element_index.h
// says what jumps cost.
#pragma once

#include <algorithm>
#include <cassert>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <ranges>

#include "sft/detail/element_index.h"
#include "sft/detail/walk.h"

namespace sft::detail {

/// The type Step defines the elements (as in struct Elements) and how an element is read. The functions of
/// std::ranges::view_interface are written out: Clang up to 15 checks the constraints of its members while
/// the derived class is still incomplete, and then refuses that class.
template <class Step>
class ElementRange : public std::ranges::view_base {
 public:
  class iterator {
    struct Arrow {
      typename Step::Value value;
      const typename Step::Value* operator->() const { return &value; }
    };

   public:
    using iterator_concept = std::random_access_iterator_tag;
    // The highest category that C++17 allows if elements are values.
    using iterator_category = std::input_iterator_tag;
    using value_type = typename Step::Value;
    using reference = value_type;
    using difference_type = std::ptrdiff_t;

    iterator() = default;

    value_type operator*() const { return Step::read(*s_, offset()); }
    Arrow operator->() const { return {**this}; }
    value_type operator[](difference_type n) const { return *(*this + n); }

    /// Moves to the next element. If the bytes are malformed, moves to the end.
    iterator& operator++() {
      const std::uint32_t next = behind(offset());
      if (next == no_offset) s_->flag_malformed();
      position_ = next == no_offset ? count_ : position_ + 1;
      known_ = {position_, next};
      return *this;
    }
    iterator operator++(int) {
      iterator before = *this;
      ++*this;
      return before;
    }
    iterator& operator--() { return *this -= 1; }
    iterator operator--(int) {
      iterator before = *this;
      --*this;
      return before;
    }

    iterator& operator+=(difference_type n) {
      position_ = static_cast<std::uint32_t>(position_ + n);
      assert(position_ <= count_);
      return *this;
    }
    iterator& operator-=(difference_type n) { return *this += -n; }
    friend iterator operator+(iterator i, difference_type n) { return i += n; }
    friend iterator operator+(difference_type n, iterator i) { return i += n; }
    friend iterator operator-(iterator i, difference_type n) { return i -= n; }
    friend difference_type operator-(const iterator& a, const iterator& b) {
      return difference_type{a.position_} - difference_type{b.position_};
    }
    friend bool operator==(const iterator& a, const iterator& b) { return a.position_ == b.position_; }
    friend auto operator<=>(const iterator& a, const iterator& b) { return a.position_ <=> b.position_; }

   private:
    friend ElementRange;
    iterator(const SampleState* s, Extent extent, std::uint32_t position)
        : s_(s), first_(extent.first), count_(extent.count), position_(position), known_{0, extent.first} {}

    /// Does the same as next_element(), for elements that are known at compile time.
    std::uint32_t behind(std::uint32_t offset) const {
      if constexpr (Step::type == nullptr) {
        return skip_string(*s_, offset);
      } else {
        return skip(*s_, *Step::type, Step::leaf, offset);
      }
    }
    Elements elements() const { return {Step::type, Step::leaf, first_, count_}; }
    std::uint32_t offset() const {
      return position_ == known_.position ? known_.offset : element_begin(*s_, elements(), position_, known_);
    }

    const SampleState* s_ = nullptr;
    std::uint32_t first_ = 0;
    std::uint32_t count_ = 0;
    std::uint32_t position_ = 0;
    KnownElement known_{};  ///< the last element that was reached by walking
  };

  ElementRange() = default;
  /// Makes the range of the elements at `extent`. If the bytes of the sample cannot contain so many
  /// elements, the range is empty and the sample is flagged.
  ElementRange(const SampleState& s, Extent extent)
      : s_(&s), extent_(checked_elements(s, extent, Step::type == nullptr ? 4 : 1)) {
    if (!extent_) extent_ = without_bytes(s, extent);
  }

  /// Returns the number of elements in the message. If no field of the elements was sent, at most
  /// max_empty_elements are between begin() and end().
  std::size_t size() const { return extent_.count; }
  bool empty() const { return extent_.count == 0; }
  explicit operator bool() const { return !empty(); }
  typename Step::Value operator[](std::ptrdiff_t n) const { return begin()[n]; }
  typename Step::Value front() const {
    assert(!empty());
    return *begin();
  }
  typename Step::Value back() const {
    assert(!empty());
    return *(end() - 1);
  }
  iterator begin() const { return {s_, extent_, 0}; }
  iterator end() const {
    const bool all = extent_.count <= max_empty_elements || have_bytes(*s_);
    return {s_, extent_, all ? extent_.count : max_empty_elements};
  }

 private:
  static bool have_bytes(const SampleState& s) {
    return Step::type == nullptr || s.mask->any_of(Step::leaf, leaf_count(*Step::type));
  }
  /// Returns the extent of elements of which no field was sent. Such elements take no bytes, so the size of
  /// the sample does not confirm their number.
  [[gnu::noinline]] static Extent without_bytes(const SampleState& s, Extent extent) {
    const Extent empty_ones = have_bytes(s) ? Extent{} : checked_elements(s, extent, 0);
    if (empty_ones) return empty_ones;
    s.flag_malformed();
    return {0, 0};
  }

  // The following two words are passed in registers.
  const SampleState* s_ = nullptr;
  Extent extent_{0, 0};
};

}  // namespace sft::detail

template <class Step>
inline constexpr bool std::ranges::enable_borrowed_range<sft::detail::ElementRange<Step>> = true;
