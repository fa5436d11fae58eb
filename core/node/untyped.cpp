#include "sft/detail/untyped.h"

#include <array>
#include <cstring>
#include <utility>

#include "core/control/control.h"
#include "core/platform/forked.h"
#include "core/publish/publisher_core.h"
#include "core/seam/sample_buffer.h"
#include "core/subscribe/remote_copy.h"
#include "core/subscribe/recorder.h"
#include "core/subscribe/subscriber_core.h"
#include "sft/dynamic_view.h"

namespace sft {

const char* to_string(PublishStatus status) {
  switch (status) {
    case PublishStatus::ok:
      return "ok";
    case PublishStatus::invalid:
      return "the message breaks a bound, has a NUL in a string, or is too large: why_invalid() names the "
             "field";
    case PublishStatus::no_loan:
      return "the loan was published already, or moved away";
    case PublishStatus::no_memory:
      return "no chunk or buffer is free";
    case PublishStatus::dropped:
      return "not handed to every reader";
    case PublishStatus::forked:
      return core::refuses_forked_copies;
  }
  return "unknown";
}

const char* to_string(ShrinkStatus status) {
  switch (status) {
    case ShrinkStatus::ok:
      return "ok";
    case ShrinkStatus::not_reserved:
      return "the loan reserved nothing for this sequence: name its size in loan()";
    case ShrinkStatus::too_long:
      return "longer than what the loan reserved for this sequence";
    case ShrinkStatus::no_loan:
      return "the loan was published already, or moved away";
  }
  return "unknown";
}

namespace detail::untyped {

using core::SampleHandle;

namespace {

SampleState view_of(core::SampleBuffer& buffer, std::size_t slots) {
  SampleState state = core::state_of(buffer, slots);
  state.elements = &buffer.elements;
  return state;
}

constexpr std::size_t slots_max = core::leaves_max;  // types with more leaves cannot be subscribed to

constexpr std::array<std::uint32_t, slots_max> absent_slots = [] {
  std::array<std::uint32_t, slots_max> slots{};
  slots.fill(no_offset);
  return slots;
}();
const FieldMask no_fields(slots_max);

}  // namespace

constinit const SampleState empty_state{.index = absent_slots.data(), .mask = &no_fields};

Sample::Sample(core::SampleBuffer* buffer, const TypeSupport& type, const SampleInfo& info,
               core::RecordedSample* record, std::shared_ptr<const Selection> selection,
               core::PartReader* parts)
    : state_(view_of(*buffer, type.index_slots())),
      info_(info),
      selection_(std::move(selection)),
      buffer_(buffer),
      record_(record),
      parts_(parts) {
  if (record_ != nullptr) state_.log = &record_->log();
  state_.parts = parts_;
}

const SampleState& Sample::whole_state() const { return parts_ == nullptr ? state_ : parts_->put_together(); }

std::vector<std::string> Sample::missing_channels(const TypeSupport& type) const {
  std::vector<std::string> missing;
  if (selection_ == nullptr) return missing;
  SampleState state = state_;
  state.log = nullptr;  // this access is not a read by the program, and must not be recorded
  const DynamicView view(state, type.type(), *state.mask);
  for (const Selection::Part& part : selection_->parts()) {
    const Layout* const layout = type.layout_of(part.leaf);
    if (part.channels.empty() || layout == nullptr) continue;
    const Layout::Field& channels = (*layout)[LayoutRole::channels];
    const std::string& size = type.path(channels.leaf);  // "fields.size"
    const std::string_view name = channels.member->type->members[0].name;
    missing.insert(missing.end(), part.channels.begin(), part.channels.end());
    for (const DynamicView& channel : view.find(size.substr(0, size.rfind('.'))).elements()) {
      if (const auto known = channel.find(name).as<std::string_view>()) std::erase(missing, *known);
    }
  }
  return missing;
}

std::span<const std::byte> Sample::cdr() const {
  if (buffer_ == nullptr) return {};
  const SampleState& whole = whole_state();
  if (whole.body == nullptr) return {};
  return {whole.body - encapsulation_bytes, whole.body_bytes + encapsulation_bytes};
}

Error Sample::error_of_missing(const TypeSupport& type) const {
  std::size_t leaf = 0;
  while (leaf < type.leaves() && state_.mask->contains(leaf)) ++leaf;
  const std::string missing = leaf < type.leaves() ? "the sample lacks '" + type.path(leaf) + "'"
                                                   : "the sample lacks channels of its points";
  return {
      Errc::unavailable,
      missing + (record_ != nullptr ? ", which was not requested yet: now all fields are, and later samples "
                                      "have them"
                                    : ": select all fields, or use fill_partial()")};
}

void Sample::reset() noexcept {
  if (core::is_forked_copy()) return leave_to_the_parent();
  if (auto* record = std::exchange(record_, nullptr)) core::Recorder::end(record);
  if (auto* parts = std::exchange(parts_, nullptr)) core::PartReader::end(parts);
  SampleHandle::adopt(std::exchange(buffer_, nullptr)).reset();
}

/// Drops the references without releasing the memory, because only the process that took the sample must
/// release it.
void Sample::leave_to_the_parent() noexcept {
  record_ = nullptr;
  parts_ = nullptr;
  buffer_ = nullptr;
}

void Sample::swap(Sample& other) noexcept {
  std::swap(state_, other.state_);
  std::swap(info_, other.info_);
  selection_.swap(other.selection_);
  std::swap(buffer_, other.buffer_);
  std::swap(record_, other.record_);
  std::swap(parts_, other.parts_);
}

Loan::Loan(std::shared_ptr<core::PublisherCore> publisher, core::SampleBuffer* buffer)
    : publisher_(std::move(publisher)), buffer_(buffer) {}

Loan::~Loan() {
  if (core::is_forked_copy()) {
    // The handle is leaked: it may be the last handle, and even the publisher must not be destroyed in a
    // forked copy.
    static_cast<void>(new std::shared_ptr<core::PublisherCore>(std::move(publisher_)));
    return;
  }
  SampleHandle::adopt(buffer_).reset();
}

void Loan::swap(Loan& other) noexcept {
  std::swap(publisher_, other.publisher_);
  std::swap(buffer_, other.buffer_);
  std::swap(has_gaps_, other.has_gaps_);
}

std::byte* Loan::body() const {
  return buffer_ == nullptr ? nullptr
                            : buffer_->data + SampleLayout(publisher_->type().index_slots()).body_offset;
}

SampleState Loan::state() const {
  return buffer_ == nullptr ? SampleState{} : view_of(*buffer_, publisher_->type().index_slots());
}

void Loan::write(std::size_t slot, const void* value, std::size_t bytes) noexcept {
  if (buffer_ == nullptr) return;
  const SampleState s = state();
  const std::uint32_t at = checked_block(s, __atomic_load_n(s.index + slot, __ATOMIC_RELAXED), 1, bytes);
  if (at != no_offset) std::memcpy(body() + at, value, bytes);
}

ShrinkStatus Loan::shrink(const Reservation& reserved, std::uint32_t length) noexcept {
  if (buffer_ == nullptr) return ShrinkStatus::no_loan;
  if (!reserved.length) return ShrinkStatus::not_reserved;
  if (length > *reserved.length) return ShrinkStatus::too_long;
  write(reserved.slot, &length, sizeof length);
  has_gaps_ = has_gaps_ || length != *reserved.length;
  return ShrinkStatus::ok;
}

PublishStatus Loan::publish() && {
  if (buffer_ == nullptr) return PublishStatus::no_loan;
  if (core::is_forked_copy()) return PublishStatus::forked;
  return publisher_->commit(SampleHandle::adopt(std::exchange(buffer_, nullptr)), has_gaps_);
}

Result<PublishStatus> Loan::publish_cdr() && {
  if (buffer_ == nullptr) return PublishStatus::no_loan;
  if (core::is_forked_copy()) return PublishStatus::forked;
  return publisher_->commit_cdr(SampleHandle::adopt(std::exchange(buffer_, nullptr)));
}

// A forked copy of a process must not even read objects that other threads were using at the time of the
// fork. No function waits for a lock in such a copy.

PublishStatus Publisher::publish(const Message& message) {
  if (core::is_forked_copy()) [[unlikely]]
    return PublishStatus::forked;
  return core_->publish(message);
}

PublishedSpan Publisher::publish(const void* values, std::size_t count, std::size_t stride) {
  if (core::is_forked_copy()) return {.status = PublishStatus::forked};
  return core_->publish(values, count, stride);
}

Result<PublishStatus> Publisher::publish_cdr(std::span<const std::byte> payload, std::int64_t stamp_ns) {
  if (core::is_forked_copy()) return PublishStatus::forked;
  return core_->publish_cdr(payload, stamp_ns);
}

Result<Loan> Publisher::loan(const void* prototype, std::span<const Reservation> reservations,
                             ReservedMemory memory) {
  if (core::is_forked_copy()) return fail(Errc::unavailable, core::refuses_forked_copies);
  return core_->loan(prototype, reservations, memory).map([this](SampleHandle&& sample) {
    return Loan(core_, sample.release());
  });
}

Result<Loan> Publisher::loan_cdr(std::size_t body_bytes) {
  if (core::is_forked_copy()) return fail(Errc::unavailable, core::refuses_forked_copies);
  return core_->loan_cdr(body_bytes).map([this](SampleHandle&& sample) {
    return Loan(core_, sample.release());
  });
}

const std::string& Publisher::why_invalid() const { return core_->why_invalid(); }

bool Publisher::wait_for_subscribers(std::size_t count, std::chrono::nanoseconds timeout) const {
  return !core::is_forked_copy() && core_->wait_for_readers(count, timeout);
}

void Publisher::assert_liveliness() {
  if (!core::is_forked_copy()) core_->assert_liveliness();
}

PublisherStatus Publisher::status() const {
  return core::is_forked_copy() ? PublisherStatus{} : core_->status();
}

const TypeSupport& Publisher::type() const { return core_->type(); }

Sample Subscriber::take() { return core::is_forked_copy() ? Sample() : core_->take(); }

Sample Subscriber::take_latest() { return core::is_forked_copy() ? Sample() : core_->take_latest(); }

/// Does not wait if it is called within a callback. The callback's thread may be the receiving thread, so
/// no sample could arrive during the wait.
bool Subscriber::wait(std::chrono::nanoseconds timeout) {
  if (core::is_forked_copy()) return false;
  return core_->wait(core::SubscriberCore::in_callback() ? std::chrono::nanoseconds(0) : timeout);
}

int Subscriber::file_descriptor() const { return core_->file_descriptor(); }

namespace {
/// Returns the part of the subscriber that delivers one selection.
Result<core::Feed*> feed_of(core::SubscriberCore& subscriber, std::size_t selection) {
  if (core::is_forked_copy()) return fail(Errc::unavailable, core::refuses_forked_copies);
  return subscriber.find(selection);
}
}  // namespace

Result<void> Subscriber::set_max_rate_hz(double max_rate_hz, std::size_t which) {
  return feed_of(*core_, which).and_then([&](core::Feed* feed) {
    return feed->set_max_rate_hz(max_rate_hz);
  });
}

Result<void> Subscriber::set_selection(const Selection& selection, std::size_t which) {
  return feed_of(*core_, which).and_then([&](core::Feed* feed) { return feed->set_selection(selection); });
}

std::size_t Subscriber::selections() const { return core_->selections(); }

SubscriberStatus Subscriber::status(std::size_t which) const {
  const Result<core::Feed*> feed = feed_of(*core_, which);
  return feed ? (*feed)->status() : SubscriberStatus{};
}

Requirements Subscriber::requirements(std::size_t which) const {
  const Result<core::Feed*> feed = feed_of(*core_, which);
  return feed ? (*feed)->requirements() : Requirements{};
}

const TypeSupport& Subscriber::type() const { return core_->type(); }

}  // namespace detail::untyped
}  // namespace sft
