#include "udp_transport/receive/delivery.h"

#include <algorithm>
#include <iterator>
#include <optional>
#include <utility>

namespace sft::udp {

namespace {
/// The maximum number of samples that are delivered in order to a reader at a time. Then it is checked again
/// that the reader still exists.
constexpr std::size_t delivered_at_once = 256;
}  // namespace

void Delivery::enter() {
  const std::shared_ptr<const Subscriptions>& latest = subscriptions_.enter();
  if (latest == wanted_) return;
  wanted_ = latest;
  reassembly_.set_streams(wanted_->streams);
  keep_groups_(reassembly_.groups());
  for (std::size_t i = 0; i < wanted_->streams.size(); ++i) follow_readers(i);
}

/// Passes the readers of a reliable stream to its window.
void Delivery::follow_readers(std::size_t stream_index) {
  ArrivalWindow* window = reassembly_.window(stream_index);
  if (window == nullptr) return;
  const std::vector<Subscriber>& subscribers = wanted_->subscribers[stream_index];
  std::vector<core::EndpointId> readers;
  for (const Subscriber& subscriber : subscribers) {
    if (subscriber.reliable) readers.push_back(subscriber.reader);
  }
  window->set_readers(readers);
  for (const Subscriber& subscriber : subscribers)
    window->heard(subscriber.reader, subscriber.heard_request());
}

void Delivery::deliver(Arrival& arrival, Time now) {
  const bool in_channel = arrival.in_channel;
  const core::EndpointId writer = wanted_->streams[arrival.stream].writer;
  const bool hands_over = arrival.may_overtake || (hand_over_.is_under_way() && hand_over_.concerns(writer));
  if (hands_over && arrival.has_samples()) [[unlikely]] {
    hand_over(arrival, writer);
  } else if (arrival.has_samples()) {
    deliver_at_once(arrival);
  }
  if (in_channel) deliver_in_order(writer, now);
}

/// Delivers to best-effort readers, which get samples in the order of arrival. Listeners run while no
/// subscriptions are in use, because listeners may take long, and may connect and destroy readers.
void Delivery::deliver_at_once(Arrival& arrival) {
  const auto in_turn = [&](const Subscriber& s) { return arrival.in_channel && s.reliable; };
  if (std::ranges::all_of(wanted_->subscribers[arrival.stream], in_turn)) return;
  const std::shared_ptr<const Subscriptions> subscriptions = wanted_;
  subscriptions_.leave();
  const std::span samples = arrival.sample ? std::span(&arrival.sample, 1) : arrival.packed;
  for (const Subscriber& subscriber : subscriptions->subscribers[arrival.stream]) {
    if (in_turn(subscriber)) continue;
    batch_.clear();
    std::ranges::copy_if(samples, std::back_inserter(batch_),
                         [&](const core::SampleHandle& sample) { return subscriber.accepts(*sample); });
    subscriber.inbox->deliver(batch_);
  }
  batch_.clear();
  for (core::SampleHandle& sample : samples) sample.reset();
  enter();
}

/// Delivers samples in the order of their sequences. A sample that came by unicast waits if an earlier
/// sample is missing.
void Delivery::hand_over(Arrival& arrival, core::EndpointId writer) {
  const std::span samples = arrival.sample ? std::span(&arrival.sample, 1) : arrival.packed;
  for (core::SampleHandle& sample : samples)
    hand_over_.add({std::move(sample), arrival.in_channel, arrival.may_overtake});
  for (HandOver::Waiting one = hand_over_.next(writer); one.sample; one = hand_over_.next(writer))
    go_on_with(std::move(one));
  while (hand_over_.is_full()) go_on_with(hand_over_.next());
}

/// Delivers a sample that waited. Does nothing if its writer has no reader any more.
void Delivery::go_on_with(HandOver::Waiting waiting) {
  const std::optional<std::size_t> index = index_of(waiting.sample->header().writer);
  if (!index) return;
  Arrival arrival{std::move(waiting.sample), *index, waiting.in_channel};
  deliver_at_once(arrival);
}

void Delivery::end_hand_over() noexcept {
  enter();
  while (hand_over_.is_under_way()) go_on_with(hand_over_.next());
  leave();
}

/// Delivers available samples to the reliable readers in order. Returns true if some reader got a sample.
bool Delivery::deliver_in_order(core::EndpointId writer, Time now) {
  bool any = false;
  while (deliver_next(writer, now)) any = true;
  return any;
}

std::optional<std::size_t> Delivery::index_of(core::EndpointId writer) const {
  const auto stream = std::ranges::find(wanted_->streams, writer, &Stream::writer);
  if (stream == wanted_->streams.end()) return {};
  return static_cast<std::size_t>(stream - wanted_->streams.begin());
}

/// Delivers available samples in order to one reliable reader, up to a limit. Returns false if no reader can
/// get a sample.
bool Delivery::deliver_next(core::EndpointId writer, Time now) {
  const std::optional<std::size_t> index = index_of(writer);
  ArrivalWindow* window = index ? reassembly_.window(*index) : nullptr;
  if (window == nullptr) return false;
  for (const Subscriber& subscriber : wanted_->subscribers[*index]) {
    if (subscriber.reliable && deliver_to(subscriber, wanted_->streams[*index], *window)) return true;
  }
  window->release();
  if (window->holds_back()) {
    lag_monitor_.begin(now);
    readers_lag_.store(true, std::memory_order_relaxed);
  }
  return false;
}

/// Delivers the available samples in order to this reader. Returns false if no sample is available for it.
/// If the result is true, the subscriptions may have changed meanwhile. If the publisher waits for its
/// readers, later samples do not displace earlier ones in the inbox.
bool Delivery::deliver_to(const Subscriber& subscriber, const Stream& stream, ArrivalWindow& window) {
  const auto accepts = [&](const core::SampleBuffer& s, std::uint64_t request) {
    return subscriber.accepts(s, request);
  };
  std::optional<KeepLastQueue::Room> room;
  if (stream.waits && !window.overtakes()) room = subscriber.inbox->room(stream.writer);
  const auto has_room = [&](const core::SampleBuffer& s) {
    return !room || room->take(s.header().body_bytes);
  };
  batch_.clear();
  while (batch_.size() < delivered_at_once) {
    core::SampleHandle sample = window.next(subscriber.reader, accepts, has_room);
    if (!sample) break;
    batch_.push_back(std::move(sample));
  }
  if (batch_.empty()) return false;
  window.release();
  const std::shared_ptr<Inbox> inbox = subscriber.inbox;
  const std::shared_ptr<const Subscriptions> subscriptions = wanted_;
  subscriptions_.leave();
  inbox->deliver(batch_, room ? KeepLastQueue::Excess::kept : KeepLastQueue::Excess::pushed_out);
  batch_.clear();
  enter();
  return true;
}

void Delivery::look_after_readers(Time now) {
  enter();
  bool some_was_taken = false;
  bool some_is_left = false;
  const std::shared_ptr<const Subscriptions> subscriptions = wanted_;
  for (const Stream& stream : subscriptions->streams) {
    if (stream.waits) some_was_taken = deliver_in_order(stream.writer, now) || some_was_taken;
  }
  for (std::size_t i = 0; i < wanted_->streams.size(); ++i) {
    const ArrivalWindow* window = reassembly_.window(i);
    some_is_left = some_is_left || (window != nullptr && window->holds_back());
  }
  leave();
  lag_monitor_.looked(now, some_was_taken, some_is_left);
  readers_lag_.store(some_is_left, std::memory_order_relaxed);
}

}  // namespace sft::udp
