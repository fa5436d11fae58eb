#include "udp_transport/destination.h"

#include <algorithm>
#include <array>
#include <random>
#include <utility>

#include "udp_transport/fragmenter.h"
#include "udp_transport/interfaces.h"

namespace sft::udp {

Destination::Destination(const SocketAddress& address, const DestinationLimits& limits, std::uint32_t flow,
                         Connect connect)
    : address_(address),
      limits_(limits),
      flow_(flow),
      connect_(std::move(connect)),
      datagram_bytes_(ask_for_datagram_bytes()),
      connection_(connect_(address)),
      window_(flow, limits.flow) {}

std::size_t Destination::ask_for_datagram_bytes() const noexcept {
  return std::min<std::size_t>(datagram_bytes_to(address_),
                               std::max(limits_.datagram_bytes, datagram_bytes_min));
}

std::size_t Destination::datagrams_per_call() const {
  return one_at_a_time_.load(std::memory_order_relaxed) ? 1 : batch_datagrams_max;
}

void Destination::set_receive_buffer(std::uint32_t bytes) {
  const std::scoped_lock lock(mutex_);
  window_.announce(bytes);
}

void Destination::note(SendOutcome outcome) noexcept {
  if (outcome == SendOutcome::no_segments) one_at_a_time_.store(true, std::memory_order_relaxed);
  if (outcome == SendOutcome::too_long)
    datagram_bytes_.store(ask_for_datagram_bytes(), std::memory_order_relaxed);
  if (outcome != SendOutcome::too_long && outcome != SendOutcome::failed) return;
  connection_->reconnect();
  if (Connection* const bulk = bulk_in_use_.load(std::memory_order_acquire)) bulk->reconnect();
}

Connection& Destination::bulk() {
  if (bulk_ == nullptr) {
    bulk_ = connect_(address_);
    bulk_->carry_bulk();
    bulk_in_use_.store(bulk_.get(), std::memory_order_release);
  }
  return *bulk_;
}

Connection& Destination::connection_after(std::uint64_t position) {
  if (position == 0) return *connection_;
  const std::scoped_lock lock(mutex_);
  return window_.passed(position) ? *connection_ : last_in_line();
}

std::size_t Destination::room(Size size, Time now) {
  const std::scoped_lock lock(mutex_);
  return window_.room(size, now);
}

std::size_t Destination::batch_bytes() {
  const std::scoped_lock lock(mutex_);
  return window_.batch_bytes();
}

void Destination::sent(const Connection& by, std::size_t bytes, std::size_t datagrams, Time now) {
  std::optional<FlowMark> due;
  {
    const std::scoped_lock lock(mutex_);
    window_.sent(bytes, datagrams, now, &by != &last_in_line());
    due = window_.mark(now);
  }
  if (due) send(*due);
}

void Destination::mark(Time now) {
  std::optional<FlowMark> due;
  {
    const std::scoped_lock lock(mutex_);
    due = window_.mark(now);
  }
  if (due) send(*due);
}

/// One that does not leave is made up for by a later one.
void Destination::send(FlowMark mark) {
  mark.port = limits_.report_port;
  std::array<std::byte, mark_bytes> encoded;
  encode(mark, encoded.data());
  const iovec part{encoded.data(), encoded.size()};
  const OutgoingBatch batch{{&part, 1}, 0};
  last_in_line().try_send({&batch, 1});
}

bool Destination::hear(const FlowReport& report, Time now) {
  const std::scoped_lock lock(mutex_);
  return window_.hear(report, now);
}

Destination::Time Destination::next_ready(Time now) {
  const std::scoped_lock lock(mutex_);
  return window_.next_ready(now);
}

std::uint64_t Destination::position() {
  const std::scoped_lock lock(mutex_);
  return window_.position();
}

DestinationDirectory::DestinationDirectory(const DestinationLimits& limits, Connect connect)
    : limits_(limits), connect_(std::move(connect)), next_flow_(std::random_device{}()) {}

std::shared_ptr<Destination> DestinationDirectory::find(const core::UdpAddress& address) {
  const SocketAddress key{address.ipv4, address.port};
  std::shared_ptr<Destination> destination;
  std::uint32_t flow = 0;
  {
    const std::scoped_lock lock(mutex_);
    std::erase_if(known_, [](const auto& entry) { return entry.second.expired(); });
    if (const auto known = known_.find(key); known != known_.end()) destination = known->second.lock();
    flow = next_flow_++;
  }
  if (destination == nullptr) {
    auto fresh = std::make_shared<Destination>(key, limits_, flow, connect_);
    const std::scoped_lock lock(mutex_);
    std::weak_ptr<Destination>& known = known_[key];
    destination = known.lock();
    if (destination == nullptr) known = destination = std::move(fresh);
  }
  if (address.receive_buffer_bytes != 0) destination->set_receive_buffer(address.receive_buffer_bytes);
  return destination;
}

std::shared_ptr<Destination> DestinationDirectory::of_flow(std::uint32_t flow) {
  const std::scoped_lock lock(mutex_);
  for (const auto& [address, known] : known_) {
    if (auto destination = known.lock(); destination != nullptr && destination->flow() == flow)
      return destination;
  }
  return nullptr;
}

}  // namespace sft::udp
