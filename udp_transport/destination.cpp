#include "udp_transport/destination.h"

#include <algorithm>
#include <utility>

#include "udp_transport/fragmenter.h"
#include "udp_transport/interfaces.h"

namespace sft::udp {

namespace {
constexpr std::uint32_t receive_buffer_bytes_default = 212'992;  // Linux, where nothing was set
}

Destination::Destination(const SocketAddress& address, const DestinationLimits& limits,
                         std::unique_ptr<Connection> connection)
    : address_(address),
      limits_(limits),
      datagram_bytes_(ask_for_datagram_bytes()),
      burst_bytes_(receive_buffer_bytes_default / 2),
      pacer_(limits.bytes_per_s),
      connection_(std::move(connection)) {}

std::size_t Destination::ask_for_datagram_bytes() const noexcept {
  return std::min<std::size_t>(datagram_bytes_to(address_),
                               std::max(limits_.datagram_bytes, datagram_bytes_min));
}

std::size_t Destination::datagrams_per_call() const {
  return one_at_a_time_.load(std::memory_order_relaxed) ? 1 : batch_datagrams_max;
}

void Destination::set_receive_buffer(std::uint32_t bytes) {
  burst_bytes_.store(std::max(bytes, receive_buffer_bytes_default) / 2, std::memory_order_relaxed);
}

void Destination::note(SendOutcome outcome) noexcept {
  if (outcome == SendOutcome::no_segments) one_at_a_time_.store(true, std::memory_order_relaxed);
  if (outcome == SendOutcome::too_long)
    datagram_bytes_.store(ask_for_datagram_bytes(), std::memory_order_relaxed);
  if (outcome == SendOutcome::too_long || outcome == SendOutcome::failed) connection_->reconnect();
}

std::shared_ptr<Destination> DestinationDirectory::find(const core::UdpAddress& address) {
  const SocketAddress key{address.ip, address.port};
  std::shared_ptr<Destination> destination;
  {
    const std::scoped_lock lock(mutex_);
    std::erase_if(known_, [](const auto& entry) { return entry.second.expired(); });
    if (const auto known = known_.find(key); known != known_.end()) destination = known->second.lock();
  }
  if (destination == nullptr) {
    auto fresh = std::make_shared<Destination>(key, limits_, connect_(key));
    const std::scoped_lock lock(mutex_);
    std::weak_ptr<Destination>& known = known_[key];
    destination = known.lock();
    if (destination == nullptr) known = destination = std::move(fresh);
  }
  if (address.receive_buffer_bytes != 0) destination->set_receive_buffer(address.receive_buffer_bytes);
  return destination;
}

}  // namespace sft::udp
