// Publishers and subscribers without message types, which are compiled into the library. The templates for
// message types (publisher.h, subscriber.h, sample.h) only add names and types to them.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sft/detail/declared_selection.h"
#include "sft/detail/loan_view.h"
#include "sft/detail/walk.h"
#include "sft/options.h"
#include "sft/requirements.h"
#include "sft/result.h"
#include "sft/sample_info.h"
#include "sft/status.h"
#include "sft/type_support.h"

namespace sft::core {
struct SampleBuffer;
class NodeCore;
class PublisherCore;
class SubscriberCore;
class PartReader;
class RecordedSample;
class SimulatedClock;
}  // namespace sft::core

namespace sft::detail {

/// The initial contents of reserved memory: zeros, or the bytes that it contained before.
enum class ReservedMemory : std::uint8_t { zeroed, as_it_is };

namespace untyped {

/// The state of an empty sample: no slot has a field. Reading a field of an empty sample is a mistake, but
/// not undefined behaviour.
extern const SampleState empty_state;

/// One received sample. It owns its memory, in shared memory or in a buffer, until it is destroyed; any
/// thread may destroy it. For each subscriber, a program can hold at most SubscriberOptions::max_held
/// samples in shared memory of one publisher. While the program holds that number, take() returns no more
/// samples of that publisher. The destruction of a sample does not wake wait().
class Sample {
 public:
  Sample() = default;
  /// Takes ownership of one reference each to `buffer`, `record` (null unless the reader records), and
  /// `parts` (null unless the sample's parts of fields are in other memory). `selection` is the selection
  /// that the sample was made for, or null if the subscriber does not show selections.
  Sample(core::SampleBuffer* buffer, const TypeSupport& type, const SampleInfo& info,
         core::RecordedSample* record, std::shared_ptr<const Selection> selection = nullptr,
         core::PartReader* parts = nullptr);
  Sample(Sample&& other) noexcept
      : state_(other.state_),
        info_(other.info_),
        selection_(std::move(other.selection_)),
        buffer_(std::exchange(other.buffer_, nullptr)),
        record_(std::exchange(other.record_, nullptr)),
        parts_(std::exchange(other.parts_, nullptr)) {}
  Sample& operator=(Sample&& other) noexcept {
    Sample gone(std::move(other));
    swap(gone);
    return *this;
  }
  ~Sample() { reset(); }

  explicit operator bool() const { return buffer_ != nullptr; }
  const SampleState& state() const { return state_; }
  /// Returns a state whose body has all fields. If parts of fields are in other memory, the first call
  /// assembles the body.
  const SampleState& whole_state() const;
  const SampleInfo& info() const { return info_; }
  /// Returns the selection that the sample was made for. Returns null if the subscriber records or does not
  /// show its selections, or if the sample is empty.
  const Selection* selection() const { return record_ == nullptr ? selection_.get() : nullptr; }
  /// Returns the requested channels that the message lacks. `type` is the type of the message.
  std::vector<std::string> missing_channels(const TypeSupport& type) const;
  /// Returns the error for a program that needs all fields, if the sample does not have all of them.
  Error error_of_missing(const TypeSupport& type) const;
  /// Returns encapsulation and body: standard CDR of the type projected to the mask. The result is empty for
  /// an empty sample.
  std::span<const std::byte> cdr() const;
  void reset() noexcept;

 private:
  void leave_to_the_parent() noexcept;
  void swap(Sample& other) noexcept;

  SampleState state_ = empty_state;
  SampleInfo info_{};
  std::shared_ptr<const Selection> selection_;
  core::SampleBuffer* buffer_ = nullptr;  // holds one reference to the buffer
  core::RecordedSample* record_ = nullptr;
  core::PartReader* parts_ = nullptr;
};

/// One sample that the program is filling. The destructor returns its memory unless the sample was published.
class Loan {
 public:
  Loan() = default;
  Loan(std::shared_ptr<core::PublisherCore> publisher, core::SampleBuffer* buffer);
  Loan(Loan&& other) noexcept { swap(other); }
  Loan& operator=(Loan&& other) noexcept {
    Loan gone(std::move(other));
    swap(gone);
    return *this;
  }
  ~Loan();

  /// Returns the body, or null if the loan was published or moved away. In these cases state() is empty.
  std::byte* body() const;
  SampleState state() const;

  /// Overwrites a primitive that has a slot. Does nothing if the loan was published or moved away.
  void write(std::size_t slot, const void* value, std::size_t bytes) noexcept;
  /// Shortens the sequence, but does not move the data after the sequence; publish() closes the gap.
  ShrinkStatus shrink(const Reservation& reserved, std::uint32_t length) noexcept;
  PublishStatus publish() &&;
  /// Publishes a loan of Publisher::loan_cdr().
  Result<PublishStatus> publish_cdr() &&;

 private:
  void swap(Loan& other) noexcept;

  std::shared_ptr<core::PublisherCore> publisher_;
  core::SampleBuffer* buffer_ = nullptr;  // holds one reference to the buffer
  bool has_gaps_ = false;
};

/// A publisher without its message type. It can be moved, but not copied. It must be used by only one
/// thread at a time.
class Publisher {
 public:
  explicit Publisher(std::shared_ptr<core::PublisherCore> core) : core_(std::move(core)) {}
  Publisher(Publisher&&) = default;
  Publisher& operator=(Publisher&&) = default;

  PublishStatus publish(const Message& message);
  /// Publishes `count` values, which lie at distances of `stride` bytes.
  PublishedSpan publish(const void* values, std::size_t count, std::size_t stride);
  /// Publishes an encoded payload of the whole type, see Publisher::publish_cdr().
  Result<PublishStatus> publish_cdr(std::span<const std::byte> payload, std::int64_t stamp_ns = 0);
  Result<Loan> loan(const void* prototype, std::span<const Reservation> reservations, ReservedMemory memory);
  /// Lends memory for a body that the program encodes.
  Result<Loan> loan_cdr(std::size_t body_bytes);
  const std::string& why_invalid() const;
  bool wait_for_subscribers(std::size_t count, std::chrono::nanoseconds timeout) const;
  void assert_liveliness();
  PublisherStatus status() const;
  const TypeSupport& type() const;

 private:
  std::shared_ptr<core::PublisherCore> core_;
};

/// A callback for samples. It must not throw: an exception that leaves a thread ends the program.
using Callback = std::function<void(Sample&&)>;

/// The requirement of a subscriber.
struct Requirement {
  /// The declared selection; if fields are recorded, the fields that are requested at first.
  Selection selection;
  bool recorded = false;
  /// The fields that the texts of SubscriberOptions may name.
  FieldsOfText fields_of_text = FieldsOfText::declared;
  /// True: samples show only the requested fields, even if a sample in shared memory has more.
  bool limits_samples = false;
  std::vector<Selection> further{};  ///< SubscriberOptions::further_selections; empty if fields are recorded
};

class Subscriber {
 public:
  explicit Subscriber(std::shared_ptr<core::SubscriberCore> core) : core_(std::move(core)) {}
  Subscriber(Subscriber&&) = default;
  Subscriber& operator=(Subscriber&&) = default;

  Sample take();
  Sample take_latest();
  bool wait(std::chrono::nanoseconds timeout);
  int file_descriptor() const;
  // `which` is the number of a selection of the subscriber.
  Result<void> set_max_rate_hz(double max_rate_hz, std::size_t which);
  Result<void> set_selection(const Selection& selection, std::size_t which);
  std::size_t selections() const;
  SubscriberStatus status(std::size_t which) const;
  Requirements requirements(std::size_t which) const;
  const TypeSupport& type() const;

 private:
  std::shared_ptr<core::SubscriberCore> core_;
};

}  // namespace untyped
}  // namespace sft::detail
