// Subscribing to a topic and publishing it in a program that was not compiled with its type:
//
//   const auto type = node.find_type("points", 2s);                              // Result<DynamicType>
//   auto sub = node.subscriber("points", *type, "header.stamp, fields[].name");  // Result<DynamicSubscriber>
//   while (auto sample = sub->take()) std::cout << sample.to_yaml().value();
//
//   auto pub = node.publisher("points", *type);                                  // Result<DynamicPublisher>
//   const auto status = pub->publish_json(R"({"width": 1024, "fields": [{"name": "x"}]})");
//   const auto status = pub->publish_yaml("{header: auto, width: 1024}");
//
// Other programs see them as ordinary subscribers and publishers, with the same transports and masks. Types
// also come from .msg text: from_msg() (msg_text.h).
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sft/detail/bytes_on_demand.h"
#include "sft/detail/misuse.h"
#include "sft/detail/untyped.h"
#include "sft/dynamic_type.h"
#include "sft/dynamic_view.h"
#include "sft/json.h"
#include "sft/msg_text.h"
#include "sft/yaml.h"

namespace sft {

/// A sample, as take() returns it and callbacks get it. It shows the fields that its subscriber declared,
/// and no other fields, even if the sample in shared memory has more fields. If the subscriber records, it
/// shows all fields of the sample. The sample keeps its type alive. Any thread may destroy it, and several
/// threads may read it at once. It may be empty, like a Sample (sample.h). In an empty sample all fields
/// are absent, and to_yaml() and to_json() return errors.
class DynamicSample {
 public:
  /// For SFT's own code.
  DynamicSample(DynamicType type, detail::untyped::Sample&& sample)
      : type_(std::move(type)), sample_(std::move(sample)) {}

  /// Returns false if there is no sample.
  explicit operator bool() const { return static_cast<bool>(sample_); }

  /// Returns a view that reads fields by their names. The view, and everything that is read through it, is
  /// valid until the sample is destroyed or moved.
  DynamicView view() const& {
    if (!sample_) [[unlikely]]
      detail::stop_at_empty_sample();
    return {sample_.state(), type_.type(), fields()};
  }
  void view() const&& = delete;

  /// Returns sequence, stamps, publisher, and the number of samples lost before this one. Valid as long as
  /// the sample.
  const SampleInfo& info() const& { return sample_.info(); }
  void info() const&& = delete;
  /// Returns the fields that view() has. Must not be called on an empty sample.
  const FieldMask& mask() const& {
    if (!sample_) [[unlikely]]
      detail::stop_at_empty_sample();
    return fields();
  }
  void mask() const&& = delete;
  /// See Sample::selection().
  const Selection* selection() const& { return sample_.selection(); }
  void selection() const&& = delete;
  /// See Sample::missing_channels().
  std::vector<std::string> missing_channels() const { return sample_.missing_channels(type_.support()); }
  /// Returns the message type. Valid as long as the sample.
  const DynamicType& type() const& { return type_; }
  /// Returns true if a read found malformed bytes, or if there was no memory for the part of a field that it
  /// had to copy.
  bool malformed() const { return sample_.state().is_malformed(); }
  /// Returns the encoded sample, valid as long as the sample: 4 bytes of encapsulation, and standard CDR of
  /// those members of the type that are in mask(). If the sample has other fields, too, the first call makes
  /// a copy without them. Empty if the bytes are malformed.
  std::span<const std::byte> cdr() const&;
  void cdr() const&& = delete;

  /// Returns the fields that mask() names as YAML, or an error if the sample is empty or malformed.
  Result<std::string> to_yaml(const YamlOptions& options = {}) const {
    return sample_ ? sft::to_yaml(view(), options) : empty_error();
  }
  /// Returns the same fields as JSON.
  Result<std::string> to_json(const JsonOptions& options = {}) const {
    return sample_ ? sft::to_json(view(), options) : empty_error();
  }

 private:
  static Result<std::string> empty_error() {
    return fail(Errc::unavailable, "the sample is empty: take() had nothing to give");
  }

  /// Returns the fields to show. A sample in shared memory may have more fields than were requested, and a
  /// sample that was sent for a former request may have fewer.
  const FieldMask& fields() const {
    const FieldMask& present = *sample_.state().mask;
    const Selection* const asked = sample_.selection();
    return asked != nullptr && present.contains(asked->mask()) ? asked->mask() : present;
  }

  DynamicType type_;
  detail::untyped::Sample sample_;
  mutable detail::BytesOnDemand declared_cdr_;
};

/// A publisher of encoded, JSON or YAML messages. It can be moved, but not copied. Only one thread at a
/// time may publish and take loans, as with Publisher (publisher.h); any thread may call the other functions
/// at any time.
class [[nodiscard]] DynamicPublisher {
 public:
  class Loan;

  /// For SFT's own code: Node::publisher() makes publishers.
  DynamicPublisher(DynamicType type, detail::untyped::Publisher publisher, std::size_t max_sample_bytes)
      : type_(std::move(type)), publisher_(std::move(publisher)), max_sample_bytes_(max_sample_bytes) {}

  /// Publishes a message that is already encoded, as Publisher::publish_cdr() does. The error says what is
  /// wrong with the payload.
  [[nodiscard]] Result<PublishStatus> publish_cdr(std::span<const std::byte> payload) {
    return publisher_.publish_cdr(payload);
  }
  /// Does the same for a message that was published before, such as one that a bridge passes on.
  /// SampleInfo::source_stamp at its readers is `source_stamp`, and lifespans and maximum rates count from
  /// it. The stamps of one publisher should not go back.
  [[nodiscard]] Result<PublishStatus> publish_cdr(
      std::span<const std::byte> payload, std::chrono::sys_time<std::chrono::nanoseconds> source_stamp) {
    return publisher_.publish_cdr(payload, source_stamp.time_since_epoch().count());
  }
  /// Lends memory for an encoded message with a body of this number of bytes. Returns an error if the message
  /// is larger than PublisherOptions::max_sample_bytes, or if no memory is free.
  [[nodiscard]] Result<Loan> loan_cdr(std::size_t bytes);
  /// Publishes a message that is given as JSON (cdr_from_json() in json.h); a stamp may be "now", and a
  /// header "auto". Errors name the path of the field and what was expected, even if there are no readers.
  /// The function allocates memory, and is meant for tools rather than for large data.
  [[nodiscard]] Result<PublishStatus> publish_json(std::string_view json) {
    return cdr_from_json(type_.type(), json, {max_sample_bytes_, std::chrono::system_clock::now()})
        .and_then([this](const auto& payload) { return publisher_.publish_cdr(payload); });
  }
  /// Does the same as publish_json() for a message that is given as YAML (json_from_yaml() in yaml.h).
  [[nodiscard]] Result<PublishStatus> publish_yaml(std::string_view yaml) {
    return json_from_yaml(type_.type(), yaml).and_then([this](const std::string& json) {
      return publish_json(json);
    });
  }

  /// See Publisher::wait_for_subscribers().
  bool wait_for_subscribers(std::size_t count, std::chrono::nanoseconds timeout) const {
    return publisher_.wait_for_subscribers(count, timeout);
  }
  /// See Publisher::assert_liveliness().
  void assert_liveliness() { publisher_.assert_liveliness(); }
  /// Returns the counts of the publisher, and the state of each subscriber of the topic.
  PublisherStatus status() const { return publisher_.status(); }
  /// Returns the message type. Valid as long as this object.
  const DynamicType& type() const { return type_; }

 private:
  DynamicType type_;
  detail::untyped::Publisher publisher_;
  std::size_t max_sample_bytes_;
};

/// An encoded message that is written in the memory from which readers on this host will read it, so that
/// publish() copies nothing. It is for programs that encode messages themselves, such as bindings of other
/// languages.
///
/// A loan can be moved, but not copied. It owns its memory until it is published; an unpublished loan
/// releases the memory when it is destroyed. A loan may outlive its publisher. It must be used by only one
/// thread at a time; any thread may destroy it.
class [[nodiscard]] DynamicPublisher::Loan {
 public:
  /// For SFT's own code: DynamicPublisher::loan_cdr() makes loans.
  Loan(detail::untyped::Loan loan, std::size_t bytes) : loan_(std::move(loan)), bytes_(bytes) {}

  /// Returns the memory of the body: XCDR1 in little-endian byte order, without the encapsulation. The
  /// address of the first byte is a multiple of 8. The memory contains pieces of earlier samples at first.
  /// So every byte must be written, including padding, which must be 0. The result is valid until the loan
  /// is published, moved or destroyed, and empty after that.
  std::span<std::byte> body() {
    std::byte* const first = loan_.body();
    return {first, first == nullptr ? 0 : bytes_};
  }
  /// Checks the body like DynamicPublisher::publish_cdr(), publishes it, and passes the memory to its
  /// readers. After an error the loan cannot be used any more. Only the thread that uses the publisher may
  /// call this.
  [[nodiscard]] Result<PublishStatus> publish() && { return std::move(loan_).publish_cdr(); }

 private:
  detail::untyped::Loan loan_;
  std::size_t bytes_;
};

inline Result<DynamicPublisher::Loan> DynamicPublisher::loan_cdr(std::size_t bytes) {
  return publisher_.loan_cdr(bytes).map(
      [bytes](detail::untyped::Loan&& loan) { return Loan(std::move(loan), bytes); });
}

/// A subscriber with the rules of Subscriber (subscriber.h) for threads, callbacks and lifetimes.
class [[nodiscard]] DynamicSubscriber {
 public:
  /// A callback for samples. The sample is destroyed after the call.
  using Callback = std::function<void(const DynamicSample&)>;

  /// For SFT's own code: Node::subscriber() makes subscribers.
  DynamicSubscriber(DynamicType type, detail::untyped::Subscriber subscriber)
      : type_(std::move(type)), subscriber_(std::move(subscriber)) {}

  /// Returns the oldest sample that was not taken yet, or an empty sample if there is none.
  [[nodiscard]] DynamicSample take() { return {type_, subscriber_.take()}; }
  /// Returns the newest sample; see Subscriber::take_latest().
  [[nodiscard]] DynamicSample take_latest() { return {type_, subscriber_.take_latest()}; }
  /// Returns true as soon as there is a sample to take, or false when the timeout has passed.
  bool wait(std::chrono::nanoseconds timeout) { return subscriber_.wait(timeout); }
  /// See Subscriber::file_descriptor().
  int file_descriptor() const { return subscriber_.file_descriptor(); }

  /// Changes selection `which`: requests other fields, parts of fields, or conditions. Publishers apply the
  /// change shortly after, and their next sample then counts as changed (Selection::Gate). If the new
  /// selection has no maximum rate, the present rate remains. Returns an error, and changes nothing, if the
  /// subscriber records, if the text is wrong, or if there is no selection `which`.
  [[nodiscard]] Result<void> set_selection(std::string_view fields, std::size_t which = 0) {
    return type_.support().parse_selection(fields).and_then(
        [&](const Selection& selection) { return subscriber_.set_selection(selection, which); });
  }
  /// Does the same as the function above with a selection that was made for this type.
  [[nodiscard]] Result<void> set_selection(const Selection& selection, std::size_t which = 0) {
    return subscriber_.set_selection(selection, which);
  }
  /// See Subscriber::selections().
  std::size_t selections() const { return subscriber_.selections(); }
  /// See Subscriber::set_max_rate_hz().
  [[nodiscard]] Result<void> set_max_rate_hz(double max_rate_hz, std::size_t which = 0) {
    return subscriber_.set_max_rate_hz(max_rate_hz, which);
  }

  /// See Subscriber::status().
  SubscriberStatus status(std::size_t which = 0) const { return subscriber_.status(which); }
  /// See Subscriber::requirements().
  Requirements requirements(std::size_t which = 0) const { return subscriber_.requirements(which); }
  /// Returns the message type. Valid as long as this object.
  const DynamicType& type() const { return type_; }

 private:
  DynamicType type_;
  detail::untyped::Subscriber subscriber_;
};

}  // namespace sft
