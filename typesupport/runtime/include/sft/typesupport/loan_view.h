// The writable side: sequences of primitives that were reserved in a loan and are filled in place.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "sft/typesupport/type_table.h"
#include "sft/typesupport/walk.h"

namespace sft {

/// That the sequence at `leaf` is to be encoded with `length` elements that are not written.
struct Reservation {
  std::size_t leaf = 0;
  std::optional<std::uint32_t> length{};
};

template <class T, std::size_t M>
constexpr Reservation reservation(std::optional<std::uint32_t> length) {
  return {leaf_offset(TypeTable<T>::type, M), length};
}

/// Members of a loaned sample of type T. Owns nothing: the loan does.
template <class T>
class LoanedPlace {
 public:
  LoanedPlace(std::byte* body, SampleState state) : body_(body), state_(state) {}

  template <std::size_t M, class E>
  std::span<E> span() const {
    const std::uint32_t offset = state_.index[slot_offset(TypeTable<T>::type, M)];
    const Extent extent = checked_sequence(state_, offset, sizeof(E));
    return extent ? std::span<E>{reinterpret_cast<E*>(body_ + extent.first), extent.count} : std::span<E>{};
  }

 private:
  std::byte* body_;
  SampleState state_;
};

}  // namespace sft
