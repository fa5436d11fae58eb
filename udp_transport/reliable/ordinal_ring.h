// A queue whose items are found by their ordinals. The ordinals of consecutive items are consecutive.
#pragma once

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace sft::udp {

template <class T>
class OrdinalRing {
 public:
  explicit OrdinalRing(std::uint64_t first) : begin_(first) {}

  std::uint64_t begin() const { return begin_; }  ///< ordinal of the first item
  std::uint64_t end() const { return begin_ + size_; }
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  bool contains(std::uint64_t ordinal) const { return ordinal >= begin_ && ordinal - begin_ < size_; }

  T& operator[](std::uint64_t ordinal) {
    assert(contains(ordinal));
    return items_[static_cast<std::size_t>(ordinal) & (items_.size() - 1)];
  }
  const T& operator[](std::uint64_t ordinal) const {
    return const_cast<OrdinalRing&>(*this)[ordinal];  // NOLINT: looks only
  }

  /// Allocates memory for `items` items in advance. REQUIRES: the ring is empty.
  void reserve(std::size_t items) {
    assert(empty());
    items_.resize(std::max(items_.size(), std::bit_ceil(items)));
  }
  /// Adds an item. Allocates only if the ring never had as many items before.
  T& push_back(T item) {
    if (size_ == items_.size()) grow();
    ++size_;
    return (*this)[end() - 1] = std::move(item);
  }
  void pop_front() {
    (*this)[begin_] = T{};
    ++begin_;
    --size_;
  }
  void pop_back() {
    (*this)[end() - 1] = T{};
    --size_;
  }
  /// Sets the ordinal of the next item. REQUIRES: the ring is empty.
  void begin_at(std::uint64_t ordinal) {
    assert(empty());
    begin_ = ordinal;
  }

 private:
  void grow() {
    std::vector<T> larger(std::max<std::size_t>(16, 2 * items_.size()));
    for (std::uint64_t i = begin_; i != end(); ++i)
      larger[static_cast<std::size_t>(i) & (larger.size() - 1)] = std::move((*this)[i]);
    items_ = std::move(larger);
  }

  std::uint64_t begin_;
  std::size_t size_ = 0;
  std::vector<T> items_;  ///< its size is a power of two
};

}  // namespace sft::udp
