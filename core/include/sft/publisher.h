// Publishing messages of type T. A publisher is used by one thread at a time.
#pragma once

#include <array>
#include <concepts>
#include <cstring>
#include <optional>
#include <utility>

#include "sft/typesupport/loan_view.h"
#include "sft/typesupport/view.h"
#include "sft/untyped.h"

namespace sft {

/// A message being filled in the memory that readers on this host will read: nothing is copied at publish().
/// `loan->data()` is a writable span of a reserved sequence, `loan.set(F::width, 1024)` writes a scalar. An
/// unpublished loan gives its memory back.
template <class T>
class Loan {
 public:
  using View = typename T::template LoanView<LoanedPlace<T>>;

  explicit Loan(untyped::Loan&& loan) : loan_(std::move(loan)) {}

  class Arrow {
   public:
    explicit Arrow(View view) : view_(view) {}
    const View* operator->() const { return &view_; }

   private:
    View view_;
  };
  Arrow operator->() & { return Arrow(View{LoanedPlace<T>{loan_.body(), loan_.state()}}); }
  void operator->() && = delete;

  /// Writes one scalar outside collections of structs.
  template <std::size_t Leaf, class V>
  void set(const FieldNode<T, Leaf, 1>&, V value) {
    constexpr ScalarPlace place = scalar_place(TypeTable<T>::type, Leaf);
    static_assert(place.found, "set() takes a scalar field outside sequences of structs");
    using Scalar = typename detail::ScalarOf<place.kind>::type;
    static_assert(std::convertible_to<V, Scalar>);
    const auto scalar = static_cast<Scalar>(value);
    std::memcpy(loan_.body() + loan_.state().index[place.slot], &scalar, sizeof scalar);
  }

  PublishStatus publish() && { return std::move(loan_).publish(); }

 private:
  struct ScalarPlace {
    bool found = false;
    Kind kind = Kind::octet;
    std::size_t slot = 0;
  };
  static constexpr ScalarPlace scalar_place(const StructType& type, std::size_t leaf) {
    std::size_t slot = 0;
    for (const Member& m : type.members) {
      const std::size_t leaves = leaf_count(m);
      if (leaf < leaves) {
        if (m.shape != Shape::single || m.kind == Kind::string) return {};
        if (is_primitive(m.kind)) return {true, m.kind, slot};
        ScalarPlace below = scalar_place(*m.type, leaf);
        below.slot += slot;
        return below;
      }
      leaf -= leaves;
      slot += slot_count(m);
    }
    return {};
  }

  untyped::Loan loan_;
};

template <class T>
class Publisher {
 public:
  explicit Publisher(untyped::Publisher publisher) : publisher_(std::move(publisher)) {}

  /// Encodes once and sends: readers on this host get one full sample, remote ones the fields they asked for.
  /// Without a reader it costs a few nanoseconds.
  PublishStatus publish(const T& message) { return publisher_.publish(&message); }

  /// A payload that is already encoded (4 bytes of encapsulation, little-endian XCDR1), as in ROS 2 bags.
  Result<PublishStatus> publish_cdr(std::span<const std::byte> payload) {
    return publisher_.publish_cdr(payload);
  }

  /// Memory for a message whose small fields are those of `prototype` and whose named sequences of primitives
  /// get `sizes` elements, uninitialised: `pub.loan(prototype, {.data = 6'291'456})`.
  Result<Loan<T>> loan(const T& prototype, const typename T::LoanSizes& sizes = {}) {
    const auto reservations = T::template LoanView<LoanedPlace<T>>::reservations(sizes);
    return publisher_.loan(&prototype, reservations).map([](untyped::Loan&& loan) {
      return Loan<T>(std::move(loan));
    });
  }

  /// A sign of life where liveliness is manual_by_topic and there is nothing to publish. Any thread, cheap.
  void assert_liveliness() { publisher_.assert_liveliness(); }

  PublisherStatus status() const { return publisher_.status(); }
  const TypeSupport& type() const { return publisher_.type(); }

 private:
  untyped::Publisher publisher_;
};

}  // namespace sft
