// Publishing messages of type T. A publisher is used by one thread at a time.
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <type_traits>
#include <utility>

#include "sft/detail/loan_view.h"
#include "sft/detail/untyped.h"
#include "sft/detail/view.h"

namespace sft {

/// A message being filled in the memory that readers on this host will read: nothing is copied at publish().
/// `loan->data()` is a writable span of a reserved sequence, `loan.set(F::width, 1024)` writes a scalar,
/// `loan.shrink(F::data, n)` gives back what was reserved beyond n elements. An unpublished loan gives its
/// memory back. Of a loan that was published or moved away spans are empty, set() does nothing and calls that
/// have a status return no_loan. Used by one thread at a time, and destroyed on any.
template <class T>
class Loan {
 public:
  using View = typename T::template LoanView<detail::LoanedPlace<T>>;
  using Reservations = decltype(View::reservations({}));

  Loan(detail::untyped::Loan&& loan, const Reservations& reserved)
      : loan_(std::move(loan)), reserved_(reserved) {}

  /// What operator->() returns.
  class Arrow {
   public:
    explicit Arrow(View view) : view_(view) {}
    const View* operator->() const { return &view_; }

   private:
    View view_;
  };
  Arrow operator->() & { return Arrow(View{detail::LoanedPlace<T>{loan_.body(), loan_.state()}}); }
  void operator->() && = delete;

  /// Writes one scalar outside collections of structs: a number, or an enumerator of the field's own
  /// enumeration.
  template <std::size_t Leaf, class V>
  void set(const detail::FieldNode<T, Leaf, 1>&, V value) {
    constexpr ScalarPlace place = scalar_place(detail::TypeTable<T>::type, Leaf);
    static_assert(place.found, "set() takes a scalar field outside sequences of structs");
    static_assert(!place.found || can_hold<V>(place), "set() takes a value of the field's own type");
    using Scalar = typename detail::ScalarOf<place.kind>::type;
    const auto scalar = static_cast<Scalar>(value);
    loan_.write(place.slot, &scalar, sizeof scalar);
  }

  /// Of a reserved sequence only the first `length` elements are published. Spans of it stay valid; what
  /// lies behind moves up at publish(). It can be called again, for any length up to what was reserved.
  template <std::size_t Leaf>
  ShrinkStatus shrink(const detail::FieldNode<T, Leaf, 1>&, std::uint32_t length) {
    constexpr std::size_t number = reservation_number(Leaf);
    static_assert(number < std::tuple_size_v<Reservations>,
                  "shrink() takes a sequence of numbers or enumerators, which loan() can reserve");
    if constexpr (number < std::tuple_size_v<Reservations>) return loan_.shrink(reserved_[number], length);
  }

  /// Hands the message over, on the thread whose turn it is to publish. The loan is empty afterwards,
  /// whatever the result.
  PublishStatus publish() && { return std::move(loan_).publish(); }

 private:
  struct ScalarPlace {
    bool found = false;
    Member::Kind kind = Member::Kind::octet;
    const EnumType* enumeration = nullptr;
    std::size_t slot = 0;
  };
  static constexpr ScalarPlace scalar_place(const StructType& type, std::size_t leaf) {
    std::size_t slot = 0;
    for (const Member& m : type.members) {
      const std::size_t leaves = leaf_count(m);
      if (leaf < leaves) {
        if (m.shape != Member::Shape::single || m.kind == Member::Kind::string) return {};
        if (detail::is_primitive(m.kind)) return {true, m.kind, m.enumeration, slot};
        ScalarPlace below = scalar_place(*m.type, leaf);
        below.slot += slot;
        return below;
      }
      leaf -= leaves;
      slot += detail::slot_count(m);
    }
    return {};
  }

  /// Bitmasks take any combination of their flags, whatever holds it.
  template <class V>
  static constexpr bool can_hold(const ScalarPlace& place) {
    if constexpr (std::is_enum_v<V>) {
      return place.enumeration == &detail::EnumTable<V>::type;
    } else {
      return std::is_arithmetic_v<V> && (place.enumeration == nullptr || place.enumeration->is_bitmask);
    }
  }

  static constexpr std::size_t reservation_number(std::size_t leaf) {
    const Reservations all = View::reservations({});
    const auto is_it = [leaf](const detail::Reservation& r) { return r.leaf == leaf; };
    return static_cast<std::size_t>(std::find_if(all.begin(), all.end(), is_it) - all.begin());
  }

  detail::untyped::Loan loan_;
  Reservations reserved_;
};

/// Moved, not copied. One thread at a time publishes and takes loans; a loan may be filled on another, but is
/// published by the thread whose turn it is. assert_liveliness(), wait_for_subscribers() and status() may be
/// called by any thread at any time. Its loans may outlive it. After its destructor and theirs neither of its
/// callbacks runs any more (unless one of these is called from within that callback).
template <class T>
class Publisher {
 public:
  explicit Publisher(detail::untyped::Publisher publisher) : publisher_(std::move(publisher)) {}

  /// Encodes once and sends: readers on this host get one full sample, remote ones the fields they asked for.
  /// Without a reader it costs a few nanoseconds. A large message that goes to one process elsewhere alone is
  /// sent by the calling thread, from where it is, as far as the receiver has room, and copied only then;
  /// what is sent of loans, and to several, is left to a thread of the node's.
  PublishStatus publish(const T& message) { return publisher_.publish(&message); }

  /// A span, vector or array of them: the same as to publish one after the other, each a sample of its own,
  /// but much cheaper where they are small and readers elsewhere: over UDP small ones share datagrams, and
  /// these system calls. All are stamped with the time of this call. publish() of a single message never
  /// waits for others to share anything with.
  template <std::convertible_to<std::span<const T>> Messages>
  requires(!std::convertible_to<Messages, const T&>) PublishedSpan publish(const Messages& messages) {
    const std::span<const T> all = messages;
    return publisher_.publish(all.data(), all.size(), sizeof(T));
  }

  /// A payload that is already encoded (4 bytes of encapsulation and a body), as in ROS 2 bags: XCDR1 and
  /// plain XCDR2 in both byte orders, see sft/detail/convert.h. It is checked on the way; without a
  /// reader, and where nothing is retained, only the encapsulation is, and it costs a few nanoseconds.
  Result<PublishStatus> publish_cdr(std::span<const std::byte> payload) {
    return publisher_.publish_cdr(payload);
  }

  /// Memory for a message whose small fields are those of `prototype` and whose named sequences of numbers or
  /// enumerators, also those in nested structs, get so many elements, all zero: `pub.loan(prototype, {.data =
  /// 6'291'456})`, `pub.loan(prototype, {.cloud = {.data = 1000}})`.
  Result<Loan<T>> loan(const T& prototype, const typename T::LoanSizes& sizes = {}) {
    return loan(prototype, sizes, detail::ReservedMemory::zeroed);
  }

  /// The same, but reserved elements are left as they are, which saves the time to zero them. The memory was
  /// used before: write every element, or shrink() the sequence to those that were written. What is not
  /// written goes out to all readers as it is: pieces of earlier samples, of this publisher or of others on
  /// this host.
  Result<Loan<T>> loan_for_overwrite(const T& prototype, const typename T::LoanSizes& sizes = {}) {
    return loan(prototype, sizes, detail::ReservedMemory::as_it_is);
  }

  /// After publish() returned PublishStatus::invalid: which field is wrong, its size and the limit, as in
  /// "topic 'map': 'names[3]' has 300 characters; its bound is 255". Of a span it is the last message that
  /// was wrong. It is put into words only then, and stays until the next message is refused; empty before
  /// that. The thread that publishes.
  const std::string& why_invalid() const { return publisher_.why_invalid(); }

  /// Sleeps until at least so many subscribers are served, so that what is published from then on is sent to
  /// them, or until the time is over; tells which. Any thread, but not in callbacks: the subscribers that it
  /// waits for would not be served meanwhile.
  bool wait_for_subscribers(std::size_t count, std::chrono::nanoseconds timeout) const {
    return publisher_.wait_for_subscribers(count, timeout);
  }

  /// A sign of life where liveliness is manual_by_topic and there is nothing to publish. Any thread, cheap.
  void assert_liveliness() { publisher_.assert_liveliness(); }

  /// Counts, and each subscriber of the topic. Any thread.
  PublisherStatus status() const { return publisher_.status(); }
  /// The message type. Any thread; valid as long as the publisher.
  const TypeSupport& type() const { return publisher_.type(); }

 private:
  Result<Loan<T>> loan(const T& prototype, const typename T::LoanSizes& sizes,
                       detail::ReservedMemory memory) {
    const auto reserved = Loan<T>::View::reservations(sizes);
    return publisher_.loan(&prototype, reserved, memory).map([&](detail::untyped::Loan&& loan) {
      return Loan<T>(std::move(loan), reserved);
    });
  }

  detail::untyped::Publisher publisher_;
};

}  // namespace sft
