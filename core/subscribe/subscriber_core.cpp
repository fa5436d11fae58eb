#include "core/subscribe/subscriber_core.h"

#include <array>
#include <cassert>
#include <optional>
#include <utility>

namespace sft::core {

namespace {

std::deque<Feed> make_feeds(const SubscriberCore::Spec& spec, Recorder* recorder) {
  const Feed::Common common{
      .type = *spec.type,
      .topic = spec.topic,
      .timeout = spec.diverted_timeout,
      .depth = spec.options.depth,
      .memory_depth = spec.memory_depth,
      .as_remote = spec.options.recording.as_remote,
      .reports_asked = spec.limits_samples || (recorder != nullptr && recorder->records_channels()),
      .recorder = recorder};
  std::deque<Feed> feeds;
  for (const Feed::Spec& feed : spec.feeds) feeds.emplace_back(feed, common);
  return feeds;
}

std::vector<SubscriberPorts*> ports_of(std::deque<Feed>& feeds) {
  std::vector<SubscriberPorts*> ports;
  for (Feed& feed : feeds) ports.push_back(&feed.ports());
  return ports;
}

}  // namespace

SubscriberCore::SubscriberCore(Spec spec, Doorbell& bell, std::shared_ptr<Recorder> recorder)
    : spec_(std::move(spec)),
      bell_(bell),
      recorder_(std::move(recorder)),
      remote_(spec_.copies == nullptr ? nullptr : RemoteCopy::make(type(), spec_.copies)),
      events_(spec_.options.on_event, spec_.event_callbacks),
      feeds_(make_feeds(spec_, recorder_.get())),
      passed_over_(feeds_.size()),
      waiter_(ports_of(feeds_), bell, spec_.poll_handle.get(), spec_.options.spin, spec_.interrupted),
      callbacks_(spec_.callback, spec_.callback_clock) {}

/// Returns the number of the selection with the sample that must be delivered first, of all samples that have
/// arrived: the oldest one, unless that of another writer has been passed over too often. If there is only
/// one selection, the function returns 0 without a check for samples.
std::optional<std::size_t> SubscriberCore::first_in_turn() {
  if (feeds_.size() == 1) return 0;
  std::array<std::optional<SampleOrigin>, SubscriberOptions::selections_max> next;
  assert(feeds_.size() <= next.size());
  std::optional<std::size_t> oldest, due;
  for (std::size_t i = 0; i < feeds_.size(); ++i) {
    next[i] = ports(i).next_origin();
    if (next[i] && (!oldest || goes_first(*next[i], *next[*oldest]))) oldest = i;
  }
  std::uint32_t longest = passed_over_max;
  for (std::size_t i = 0; i < feeds_.size(); ++i) {
    if (!next[i]) continue;
    const std::uint32_t times = passed_over_[i].fetch_add(1, std::memory_order_relaxed);
    if (times < longest || next[i]->writer == next[*oldest]->writer) continue;
    due = i;
    longest = times;
  }
  // An earlier sample of the same writer may be that of another selection.
  for (std::size_t i = 0; due && i < feeds_.size(); ++i) {
    if (next[i] && next[i]->writer == next[*due]->writer && goes_first(*next[i], *next[*due])) due = i;
  }
  if (due) oldest = due;
  if (oldest) passed_over_[*oldest].store(0, std::memory_order_relaxed);
  return oldest;
}

detail::untyped::Sample SubscriberCore::take(Next (SubscriberPorts::*choose)()) {
  for (;;) {
    const std::optional<std::size_t> selection = first_in_turn();
    Delivery next;
    if (selection) static_cast<Next&>(next) = (ports(*selection).*choose)();
    waiter_.taken();
    if (!next.sample) {
      if (!selection || feeds_.size() == 1) return {};
      continue;  // another thread has taken that sample
    }
    next.info.selection = static_cast<std::uint32_t>(*selection);
    if (!next.is_copied || reduce(next)) return wrap(std::move(next));
  }
}

detail::untyped::Sample SubscriberCore::take() { return take(&SubscriberPorts::take); }

detail::untyped::Sample SubscriberCore::take_latest() { return take(&SubscriberPorts::take_latest); }

/// Reduces the sample to the fields that the subscriber asked for. If the subscriber asked for parts of
/// fields, the sample stays whole, and the parts are read from it. Returns false if the sample cannot be
/// reduced; a reader on another host would have missed it, too.
bool SubscriberCore::reduce(Delivery& delivery) {
  if (delivery.asked->plan != nullptr) {
    RemoteCopy::InPlace reduced = remote_->in_place(std::move(delivery.sample), delivery.asked);
    delivery.sample = std::move(reduced.sample);
    delivery.parts = reduced.parts;
  }
  const bool is_delivered = static_cast<bool>(delivery.sample);
  ports(delivery.info.selection).copied(delivery.info, is_delivered);
  return is_delivered;
}

detail::untyped::Sample SubscriberCore::wrap(Delivery delivery) {
  const std::shared_ptr<const Asked>& asked = delivery.asked;
  std::shared_ptr<const Selection> selection;
  if (asked != nullptr) selection = {asked, &asked->selection};
  RecordedSample* const record = recorder_ == nullptr ? nullptr : recorder_->begin();
  if (record != nullptr && delivery.sample->parts != 0 && asked != nullptr && asked->recorded_channels)
    record->set_channels_sent({asked, &*asked->recorded_channels});
  return detail::untyped::Sample(delivery.sample.release(), type(), delivery.info, record,
                                 std::move(selection), delivery.parts);
}

Result<Feed*> SubscriberCore::find(std::size_t selection) {
  if (selection < feeds_.size()) return &feeds_[selection];
  return fail(Errc::invalid_argument, "topic '" + spec_.topic + "': there is no selection " +
                                          std::to_string(selection) + "; the subscriber has " +
                                          std::to_string(feeds_.size()) + ", which are numbered from 0");
}

bool SubscriberCore::waits_for_dispatch() {
  if (waiter_.has_descriptor()) return waiter_.has_unshown();
  return callbacks_.is_idle() && available();
}

void SubscriberCore::arrived() noexcept {
  if (has_callback() && !callbacks_.is_slow()) {
    call_back(CallbackDispatch::Caller::transport);
  } else {
    waiter_.sample_arrived();
  }
}

void SubscriberCore::dispatch() {
  if (waiter_.has_descriptor()) return waiter_.show_if_available();
  call_back(CallbackDispatch::Caller::dispatcher);
}

void SubscriberCore::call_back(CallbackDispatch::Caller caller) {
  if (!callbacks_.dispatch(caller, *this)) bell_.ring();
}

void SubscriberCore::close() {
  callbacks_.close();
  events_.clear();
  if (recorder_ != nullptr) recorder_->detach();
}

}  // namespace sft::core
