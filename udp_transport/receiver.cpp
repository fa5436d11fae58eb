#include "udp_transport/receiver.h"

#include <chrono>
#include <new>
#include <utility>

#include "core/thread.h"

namespace sft::udp {

namespace {
using Clock = std::chrono::steady_clock;
}

Receiver::Receiver(std::unique_ptr<DatagramReceiver> io, const ReassemblyLimits& limits,
                   std::shared_ptr<core::BufferPool> pool)
    : io_(std::move(io)), reassembly_(limits, std::move(pool)) {}

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
    if (!io_->receive(*this, reassembly_.next_expiry().value_or(Clock::time_point::max()))) {
      broken_.store(true, std::memory_order_relaxed);
      break;
    }
    if (!reassembly_.next_expiry()) continue;
    reassembly_.expire(Clock::now());
    publish_counters();
  }
  io_->finish();
}

void Receiver::begin(ArrivalTime now) noexcept {
  now_ = now;
  enter();
}

void Receiver::datagram(std::span<const std::byte> bytes, SocketAddress) noexcept {
  if (Reassembly::Arrival arrival = accept(bytes); arrival.sample) deliver(std::move(arrival));
}

Reassembly::Arrival Receiver::accept(std::span<const std::byte> bytes) noexcept try {
  return reassembly_.accept(bytes, now_);
} catch (const std::bad_alloc&) {  // as if the datagram had not come
  return {};
}

void Receiver::end() noexcept {
  publish_counters();
  subscriptions_.leave();
}

void Receiver::enter() {
  std::shared_ptr<const Subscriptions> latest = subscriptions_.enter();
  if (latest == wanted_) return;
  wanted_ = std::move(latest);
  reassembly_.set_streams(wanted_->streams);
}

/// Listeners run outside the snapshot: they may take long, and may connect and destroy readers.
void Receiver::deliver(Reassembly::Arrival arrival) {
  publish_counters();
  const std::shared_ptr<const Subscriptions> subscriptions = wanted_;
  subscriptions_.leave();
  for (const Subscriber& subscriber : subscriptions->subscribers[arrival.stream]) {
    if (subscriber.accepts(*arrival.sample)) subscriber.inbox->deliver(arrival.sample);
  }
  arrival.sample.reset();
  enter();
}

void Receiver::publish_counters() noexcept {
  const Reassembly::Counters& counters = reassembly_.counters();
  malformed_.store(counters.malformed, std::memory_order_relaxed);
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
