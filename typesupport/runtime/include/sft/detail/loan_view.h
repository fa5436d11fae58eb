// The writable side of loans: sequences of primitives that were reserved in a loan and are filled in place.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "sft/detail/type_table.h"
#include "sft/detail/walk.h"

namespace sft::detail {

/// Reserves `length` elements for the sequence at `leaf`, which has its own `slot`. encode() does not write
/// these elements. If `length` is empty, the sequence is encoded normally.
struct Reservation {
  std::size_t leaf = 0;
  std::optional<std::uint32_t> length{};
  std::size_t slot = 0;
};

/// Returns the reservations for member M of T: a sequence, or the sequences in a struct S. Generated code
/// calls this function.
template <class T, std::size_t M>
constexpr std::array<Reservation, 1> reservations_of(std::optional<std::uint32_t> length) {
  return {{{leaf_offset(TypeTable<T>::type, M), length, slot_offset(TypeTable<T>::type, M)}}};
}

template <class T>
class LoanedPlace;

template <class T, std::size_t M, class S>
constexpr auto reservations_of(const typename S::LoanSizes& sizes) {
  auto inner = S::template LoanView<LoanedPlace<S>>::reservations(sizes);
  for (Reservation& r : inner) {
    r.leaf += leaf_offset(TypeTable<T>::type, M);
    r.slot += slot_offset(TypeTable<T>::type, M);
  }
  return inner;
}

template <std::size_t... N>
constexpr auto joined(const std::array<Reservation, N>&... parts) {
  std::array<Reservation, (0 + ... + N)> all{};
  [[maybe_unused]] auto to = all.begin();
  ((to = std::copy(parts.begin(), parts.end(), to)), ...);
  return all;
}

/// The members of a struct T in a loaned sample. The loan owns the memory.
template <class T>
class LoanedPlace {
 public:
  /// `slot` is the first slot of T in the root type. If `body` is null, because the loan has ended, all
  /// spans are empty.
  LoanedPlace(std::byte* body, const SampleState& state, std::size_t slot = 0)
      : body_(body), state_(state), slot_(slot) {}

  template <std::size_t M, class E>
  std::span<E> span() const {
    if (body_ == nullptr) return {};
    const std::uint32_t offset = state_.index[slot_of<M>()];
    const Extent extent = checked_sequence(state_, offset, sizeof(E));
    return extent ? std::span<E>{reinterpret_cast<E*>(body_ + extent.first), extent.count} : std::span<E>{};
  }

  template <std::size_t M, class S>
  auto member() const {
    using Place = LoanedPlace<S>;
    return typename S::template LoanView<Place>{Place{body_, state_, slot_of<M>()}};
  }

 private:
  template <std::size_t M>
  std::size_t slot_of() const {
    return slot_ + slot_offset(TypeTable<T>::type, M);
  }

  std::byte* body_;
  SampleState state_;
  std::size_t slot_;
};

}  // namespace sft::detail
