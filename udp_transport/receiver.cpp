#include "udp_transport/receiver.h"

#include <algorithm>
#include <chrono>
#include <new>
#include <utility>

#include "core/thread.h"

namespace sft::udp {

namespace {
using Clock = std::chrono::steady_clock;
}

Receiver::Receiver(std::unique_ptr<DatagramReceiver> io, const ReassemblyLimits& limits,
                   std::shared_ptr<core::BufferPool> pool, Acks acks, Groups groups)
    : io_(std::move(io)),
      acks_(std::move(acks)),
      groups_(std::move(groups)),
      reassembly_(limits, std::move(pool)) {}

Result<void> Receiver::start(const std::string& thread_name) {
  Result<std::thread> started = core::start_thread(thread_name, [self = shared_from_this()] { self->run(); });
  if (!started) return tl::unexpected<Error>(std::move(started.error()));
  thread_ = std::move(*started);
  return {};
}

void Receiver::stop() {
  stopping_.store(true, std::memory_order_release);
  io_->wake();
  if (!thread_.joinable()) return;
  if (thread_.get_id() == std::this_thread::get_id()) {
    thread_.detach();  // ends by itself, on what it keeps alive
  } else {
    thread_.join();
  }
}

void Receiver::run() {
  while (!stopping_.load(std::memory_order_acquire)) {
    if (!io_->receive(*this, next_deadline())) {
      broken_.store(true, std::memory_order_relaxed);
      break;
    }
    if (next_deadline() == Clock::time_point::max()) continue;
    const Clock::time_point now = Clock::now();
    answer(now);
    reassembly_.expire(now);
    publish_counters();
  }
  io_->finish();
}

Clock::time_point Receiver::next_deadline() const {
  return std::min(reassembly_.next_answer(), reassembly_.next_expiry().value_or(Clock::time_point::max()));
}

void Receiver::answer(Clock::time_point now) noexcept try {
  reassembly_.answer(now, acks_.send);
  reassembly_.report(groups_.send);
} catch (const std::bad_alloc&) {  // it is asked for later
}

void Receiver::begin(ArrivalTime now) noexcept {
  now_ = now;
  enter();
}

void Receiver::datagram(std::span<const std::byte> bytes, SocketAddress from) noexcept {
  const std::optional<DatagramKind> kind = kind_of(bytes);
  if (kind == DatagramKind::ack) return hear_ack(bytes);
  if (kind == DatagramKind::group_offer) return hear_offer(bytes, from);
  if (kind == DatagramKind::group_report) return hear_report(bytes);
  Reassembly::Arrival arrival =
      kind == DatagramKind::heartbeat ? accept_heartbeat(bytes, from) : accept(bytes);
  const bool in_channel = arrival.in_channel;
  if (!arrival.sample && !in_channel) return;
  const core::EndpointId writer = wanted_->streams[arrival.stream].writer;
  if (arrival.sample) deliver(std::move(arrival));
  if (in_channel) deliver_in_order(writer);
}

void Receiver::hear_ack(std::span<const std::byte> bytes) noexcept try {
  const std::optional<Ack> ack = parse_ack(bytes);
  if (!ack) {
    ++malformed_answers_;
  } else {
    acks_.hear(*ack);
  }
} catch (const std::bad_alloc&) {  // another one will come
}

void Receiver::hear_offer(std::span<const std::byte> bytes, SocketAddress from) noexcept try {
  const std::optional<GroupOffer> offer = reassembly_.accept_offer(bytes, from);
  if (!offer) return;
  groups_.joins->keep_to(reassembly_.groups());
  if (offer->address != 0) groups_.joins->join(offer->address, from);
} catch (const std::bad_alloc&) {  // another one will come
}

void Receiver::hear_report(std::span<const std::byte> bytes) noexcept try {
  const std::optional<GroupReport> report = parse_group_report(bytes);
  if (!report) {
    ++malformed_answers_;
  } else {
    groups_.hear(*report);
  }
} catch (const std::bad_alloc&) {  // another one will come
}

Reassembly::Arrival Receiver::accept_heartbeat(std::span<const std::byte> bytes, SocketAddress from) noexcept
    try {
  return reassembly_.accept_heartbeat(bytes, from, now_);
} catch (const std::bad_alloc&) {
  return {};
}

Reassembly::Arrival Receiver::accept(std::span<const std::byte> bytes) noexcept try {
  return reassembly_.accept(bytes, now_);
} catch (const std::bad_alloc&) {  // as if the datagram had not come
  return {};
}

void Receiver::end() noexcept {
  publish_counters();
  subscriptions_.leave();
  answer(now_.steady);
}

void Receiver::enter() {
  std::shared_ptr<const Subscriptions> latest = subscriptions_.enter();
  if (latest == wanted_) return;
  wanted_ = std::move(latest);
  reassembly_.set_streams(wanted_->streams);
  groups_.joins->keep_to(reassembly_.groups());
  for (std::size_t i = 0; i < wanted_->streams.size(); ++i) {
    ArrivalWindow* window = reassembly_.window(i);
    if (window == nullptr) continue;
    std::vector<core::EndpointId> readers;
    for (const Subscriber& subscriber : wanted_->subscribers[i]) {
      if (subscriber.reliable) readers.push_back(subscriber.reader);
    }
    window->set_readers(readers);
  }
}

/// To those who take it as it comes. Listeners run outside the snapshot: they may take long, and may connect
/// and destroy readers.
void Receiver::deliver(Reassembly::Arrival arrival) {
  publish_counters();
  const auto in_turn = [&](const Subscriber& s) { return arrival.in_channel && s.reliable; };
  if (std::ranges::all_of(wanted_->subscribers[arrival.stream], in_turn)) return;
  const std::shared_ptr<const Subscriptions> subscriptions = wanted_;
  subscriptions_.leave();
  for (const Subscriber& subscriber : subscriptions->subscribers[arrival.stream]) {
    if (!in_turn(subscriber) && subscriber.accepts(*arrival.sample))
      subscriber.inbox->deliver(arrival.sample);
  }
  arrival.sample.reset();
  enter();
}

void Receiver::deliver_in_order(core::EndpointId writer) {
  while (deliver_next(writer)) {
  }
}

/// False if nobody has anything to get now.
bool Receiver::deliver_next(core::EndpointId writer) {
  const std::vector<Stream>& streams = wanted_->streams;
  const auto stream =
      std::ranges::find_if(streams, [&](const Stream& candidate) { return candidate.writer == writer; });
  if (stream == streams.end()) return false;
  const auto place = static_cast<std::size_t>(stream - streams.begin());
  ArrivalWindow* window = reassembly_.window(place);
  if (window == nullptr) return false;
  for (const Subscriber& subscriber : wanted_->subscribers[place]) {
    if (!subscriber.reliable) continue;
    core::SampleHandle sample =
        window->next(subscriber.reader, [&](const core::SampleBuffer& s) { return subscriber.accepts(s); });
    if (!sample) continue;
    const std::shared_ptr<Inbox> inbox = subscriber.inbox;
    const std::shared_ptr<const Subscriptions> subscriptions = wanted_;
    subscriptions_.leave();
    inbox->deliver(std::move(sample));
    enter();
    return true;
  }
  window->release();
  return false;
}

void Receiver::publish_counters() noexcept {
  const Reassembly::Counters& counters = reassembly_.counters();
  malformed_.store(counters.malformed + malformed_answers_, std::memory_order_relaxed);
  unknown_.store(counters.unknown, std::memory_order_relaxed);
  incomplete_.store(counters.incomplete, std::memory_order_relaxed);
  over_limit_.store(counters.over_limit, std::memory_order_relaxed);
}

core::Transport::Counters Receiver::counters() const noexcept {
  return {.malformed = malformed_.load(std::memory_order_relaxed),
          .unknown = unknown_.load(std::memory_order_relaxed),
          .incomplete = incomplete_.load(std::memory_order_relaxed),
          .over_limit = over_limit_.load(std::memory_order_relaxed)};
}

}  // namespace sft::udp
