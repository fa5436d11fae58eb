// Publishing messages of type T: Publisher<T>, and Loan<T>, a message that is filled in place.
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
#include "sft/detail/struct_in.h"
#include "sft/detail/untyped.h"
#include "sft/detail/view.h"

namespace sft {

/// A message that is filled in the memory from which readers on this host will read it, so that publish()
/// copies nothing. `loan->data()` is a writable span of a reserved sequence, `loan.set(F::width, 1024)`
/// writes a scalar, and `loan.shrink(F::data, n)` removes the reserved elements after the first n.
///
/// A loan can be moved, but not copied. It owns its memory until it is published; an unpublished loan
/// releases the memory when it is destroyed. A loan may outlive its publisher. It must be used by only one
/// thread at a time; any thread may destroy it. Spans are valid until the loan is published, moved or
/// destroyed. After a loan was published or moved away its spans are empty, set() does nothing, and
/// functions with a status return no_loan.
template <class T>
class [[nodiscard]] Loan {
 public:
  /// The type that gives access to the writable members of the loan.
  using View = typename T::template LoanView<detail::LoanedPlace<T>>;
  /// The sequences of T that a loan can reserve.
  using Reservations = decltype(View::reservations({}));

  /// For SFT's own code: Publisher::loan() makes loans.
  Loan(detail::untyped::Loan&& loan, const Reservations& reserved)
      : loan_(std::move(loan)), reserved_(reserved) {}

  /// The result of operator->().
  class Arrow {
   public:
    explicit Arrow(View view) : view_(view) {}
    const View* operator->() const { return &view_; }

   private:
    View view_;
  };
  /// Gives access to the writable members, in place. Does not compile on a temporary loan.
  Arrow operator->() & { return Arrow(View{detail::LoanedPlace<T>{loan_.body(), loan_.state()}}); }
  void operator->() && = delete;

  /// Writes one scalar field that is not in a sequence or an array of structs. The value must be a number, or
  /// an enumerator of the field's own enumeration. Other values do not compile.
  template <std::size_t Leaf, class V>
  void set(const detail::FieldNode<T, Leaf, 1>&, V value) {
    constexpr ScalarPlace place = scalar_place(detail::TypeTable<T>::type, Leaf);
    static_assert(place.found, "set() takes a scalar field outside sequences of structs");
    static_assert(!place.found || can_hold<V>(place), "set() takes a value of the field's own type");
    using Scalar = detail::ScalarOf<place.kind>;
    const auto scalar = static_cast<Scalar>(value);
    loan_.write(place.slot, &scalar, sizeof scalar);
  }

  /// Shortens a reserved sequence: only its first `length` elements will be published. Spans of the
  /// sequence stay valid; publish() moves the data that follow the sequence. shrink() can be called again,
  /// for any length up to the reserved one.
  template <std::size_t Leaf>
  ShrinkStatus shrink(const detail::FieldNode<T, Leaf, 1>&, std::uint32_t length) {
    constexpr std::size_t number = reservation_number(Leaf);
    static_assert(number < std::tuple_size_v<Reservations>,
                  "shrink() takes a sequence of numbers or enumerators, which loan() can reserve");
    if constexpr (number < std::tuple_size_v<Reservations>) return loan_.shrink(reserved_[number], length);
  }

  /// Publishes the message, and passes the memory to its readers. Only the thread that uses the publisher may
  /// call this.
  PublishStatus publish() && { return std::move(loan_).publish(); }
  /// An overload whose call never compiles; the compiler's message says what to write instead.
  template <int Moved = 0>
  PublishStatus publish() & {
    static_assert(Moved != 0, "a loan is gone once it is published: write std::move(loan).publish()");
    return PublishStatus::no_loan;
  }

 private:
  struct ScalarPlace {
    bool found = false;
    detail::Kind kind = detail::Kind::octet;
    const EnumType* enumeration = nullptr;
    std::size_t slot = 0;
  };
  static constexpr ScalarPlace scalar_place(const StructType& type, std::size_t leaf) {
    std::size_t slot = 0;
    for (const StructType::Member& m : type.members) {
      const std::size_t leaves = leaf_count(m);
      if (leaf < leaves) {
        if (m.shape != detail::Shape::single || m.kind == detail::Kind::string) return {};
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

  /// Returns true if a V can be written to the field. A bitmask takes any number, because every number is a
  /// combination of flags.
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

/// Publishes messages of type T on one topic; Node::publisher() opens it. It can be moved, but not copied,
/// and keeps its node alive. Only one thread at a time may publish and take loans. If a second thread does
/// so at the same time, the program ends with a line that names this mistake. A loan may be filled on
/// another thread, but must be published by the thread that uses the publisher at that time. Any thread may
/// call assert_liveliness(), wait_for_subscribers(), status() and type() at any time. Loans may outlive the
/// publisher. After the destructors of the publisher and of its loans none of its callbacks runs any more
/// (unless such a destructor is called from within the callback).
template <class T>
class [[nodiscard]] Publisher {
 public:
  /// For SFT's own code: Node::publisher() opens publishers.
  explicit Publisher(detail::untyped::Publisher publisher) : publisher_(std::move(publisher)) {}

  /// Encodes the message once and sends it. Readers on this host get one sample with all fields, and
  /// readers on other hosts get the fields that they have requested. Without a reader the call takes a few
  /// nanoseconds. If only one process on another host reads, the calling thread sends a large message
  /// without a copy, as far as the receive buffer of that process allows; only the rest is copied. Loans,
  /// and messages for several processes, are sent by a thread of the node. The message may be changed or
  /// destroyed when the function returns.
  PublishStatus publish(const T& message) {
    return publisher_.publish({detail::TypeTable<T>::type, &message});
  }

  /// Does the same for a struct that ROS 2's rosidl made of the same .msg file as T, without a copy to a T.
  /// The bytes are those of ROS 2. A struct that has other members than T does not compile.
  template <detail::OtherStruct<T> S>
  PublishStatus publish(const S& message) {
    return publisher_.publish({detail::StructIn<T, S>::type, &message});
  }

  /// Publishes a span, vector or array of messages. Each message becomes a separate sample, as if the
  /// messages were published one after the other. For small messages to other hosts this is much cheaper
  /// than single calls, because small samples share datagrams and system calls. All samples have the time
  /// of this call as their stamp. (publish() of a single message sends it at once, and never waits for
  /// further messages with which it could share a datagram.)
  template <std::convertible_to<std::span<const T>> Messages>
  requires(!std::convertible_to<Messages, const T&>) PublishedSpan publish(const Messages& messages) {
    const std::span<const T> all = messages;
    return publisher_.publish(all.data(), all.size(), sizeof(T));
  }

  /// Publishes a message that is already encoded (4 bytes of encapsulation and a body), as in ROS 2 bags:
  /// XCDR1 and plain XCDR2 in both byte orders (sft/detail/convert.h has the table). The payload is checked;
  /// an error says what is wrong with it. If there is no reader and nothing is retained, only the
  /// encapsulation is checked, which takes a few nanoseconds.
  [[nodiscard]] Result<PublishStatus> publish_cdr(std::span<const std::byte> payload) {
    return publisher_.publish_cdr(payload);
  }

  /// Lends memory for a message. Its fields are those of `prototype`, but each sequence that `sizes` names
  /// has the given number of elements, which are all zero: `pub.loan(prototype, {.data = 6'291'456})`.
  /// `sizes` can name sequences of numbers or enumerators, including those in nested structs: `{.cloud =
  /// {.data = 1000}}`. Returns an error if `prototype` cannot be encoded, if the message is larger than
  /// PublisherOptions::max_sample_bytes, or if no memory is free.
  [[nodiscard]] Result<Loan<T>> loan(const T& prototype, const typename T::LoanSizes& sizes = {}) {
    return loan(prototype, sizes, detail::ReservedMemory::zeroed);
  }

  /// Lends memory like loan(), but does not set the reserved elements to zero, which saves time. Write
  /// every element, or shrink() the sequence to the elements that were written. Elements that are not
  /// written are sent to all readers as they are, and contain pieces of earlier samples of this publisher
  /// or of other publishers on this host.
  [[nodiscard]] Result<Loan<T>> loan_for_overwrite(const T& prototype,
                                                   const typename T::LoanSizes& sizes = {}) {
    return loan(prototype, sizes, detail::ReservedMemory::as_it_is);
  }

  /// Returns the reason why publish() returned PublishStatus::invalid: the field that is wrong, its size
  /// and the limit, as in "topic 'map': 'names[3]' has 300 characters; its bound is 255". For a span the
  /// text is about the last message that was wrong. The text stays the same until the next message is
  /// refused, and is empty before the first refusal. Only the thread that publishes may call this.
  const std::string& why_invalid() const { return publisher_.why_invalid(); }

  /// Sleeps until at least `count` subscribers are served, and then returns true. Returns false if the
  /// timeout has passed. A subscriber with several selections counts once for each selection, and unmodified
  /// readers of DDS and ROS 2 count, too. If the result is true, messages that are published later are sent
  /// to these subscribers. Must not be called in callbacks: the node would not serve these subscribers
  /// meanwhile.
  bool wait_for_subscribers(std::size_t count, std::chrono::nanoseconds timeout) const {
    return publisher_.wait_for_subscribers(count, timeout);
  }

  /// Asserts that the publisher is alive. A program with the liveliness manual_by_topic must call this
  /// while it has nothing to publish. The call takes little time.
  void assert_liveliness() { publisher_.assert_liveliness(); }

  /// Returns the counts of the publisher, and the state of each subscriber of the topic. Any thread may
  /// call this.
  PublisherStatus status() const { return publisher_.status(); }
  /// Returns the message type, which is valid as long as the publisher. Any thread may call this.
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
