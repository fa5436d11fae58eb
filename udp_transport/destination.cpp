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
    : limits_(limits),
      address_(address),
      datagram_bytes_(ask_for_datagram_bytes()),
      burst_bytes_(receive_buffer_bytes_default / 2),
      pacer_(limits.bytes_per_s),
      connection_(std::move(connection)) {}

std::size_t Destination::ask_for_datagram_bytes() const noexcept {
  return std::min<std::size_t>(datagram_bytes_to(address()),
                               std::max(limits_.datagram_bytes, datagram_bytes_min));
}

std::size_t Destination::datagrams_per_call() const {
  return one_at_a_time_.load(std::memory_order_relaxed) ? 1 : batch_datagrams_max;
}

void Destination::set_receive_buffer(std::uint32_t bytes) {
  burst_bytes_.store(std::max(bytes, receive_buffer_bytes_default) / 2, std::memory_order_relaxed);
}

SocketAddress Destination::address() const {
  const std::scoped_lock lock(mutex_);
  return address_;
}

void Destination::move_to(const SocketAddress& address) noexcept {
  {
    const std::scoped_lock lock(mutex_);
    if (address == std::exchange(address_, address)) return;
  }
  connection_->redirect(address);
  datagram_bytes_.store(ask_for_datagram_bytes(), std::memory_order_relaxed);
  moves_.fetch_add(1, std::memory_order_relaxed);
}

void Destination::note(SendOutcome outcome) noexcept {
  if (outcome == SendOutcome::no_segments) one_at_a_time_.store(true, std::memory_order_relaxed);
  if (outcome == SendOutcome::too_long)
    datagram_bytes_.store(ask_for_datagram_bytes(), std::memory_order_relaxed);
  if (outcome == SendOutcome::too_long || outcome == SendOutcome::failed) connection_->reconnect();
}

DestinationDirectory::Key DestinationDirectory::key_of(const core::UdpAddress& address) {
  return {address.node, {address.node == 0 ? address.ip : core::IpAddress{}, address.port}};
}

/// With the mutex held. Whoever does not know whose an address is may find one that is there at present.
std::shared_ptr<Destination> DestinationDirectory::known(const core::UdpAddress& address) {
  std::erase_if(known_, [](const auto& entry) { return entry.second.expired(); });
  if (const auto found = known_.find(key_of(address)); found != known_.end()) return found->second.lock();
  if (address.node != 0) return nullptr;
  for (const auto& [key, entry] : known_) {
    std::shared_ptr<Destination> destination = entry.lock();
    if (destination != nullptr && destination->address() == SocketAddress{address.ip, address.port})
      return destination;
  }
  return nullptr;
}

std::shared_ptr<Destination> DestinationDirectory::find(const core::UdpAddress& address) {
  const SocketAddress to{address.ip, address.port};
  std::shared_ptr<Destination> destination;
  {
    const std::scoped_lock lock(mutex_);
    destination = known(address);
  }
  if (destination == nullptr) {
    auto fresh = std::make_shared<Destination>(to, limits_, connect_(to));
    const std::scoped_lock lock(mutex_);
    destination = known(address);
    if (destination == nullptr) known_[key_of(address)] = destination = std::move(fresh);
  }
  if (address.node != 0) destination->move_to(to);
  if (address.receive_buffer_bytes != 0) destination->set_receive_buffer(address.receive_buffer_bytes);
  return destination;
}

}  // namespace sft::udp
