// A socket that samples are sent to, shared by all writers that serve readers behind it.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>

#include "core/transport.h"
#include "udp_transport/datagram.h"
#include "udp_transport/datagram_io.h"
#include "udp_transport/pacer.h"

namespace sft::udp {

struct DestinationLimits {
  std::uint64_t bytes_per_s = 0;  ///< 0: none
  std::size_t datagram_bytes = datagram_bytes_max;
};

class Destination {
 public:
  Destination(const SocketAddress& address, const DestinationLimits& limits);

  const SocketAddress& address() const { return address_; }
  std::size_t datagram_bytes() const { return datagram_bytes_.load(std::memory_order_relaxed); }
  std::size_t datagrams_per_call() const;
  /// Half of what the receiving socket holds: the kernel counts more than the bytes.
  std::size_t burst_bytes() const { return burst_bytes_.load(std::memory_order_relaxed); }
  void set_receive_buffer(std::uint32_t bytes);

  /// Learns from a send that was refused; the next one fits. Any thread.
  void note(SendOutcome outcome) noexcept;

  /// Of the sending thread alone.
  Pacer& pacer() { return pacer_; }

 private:
  std::size_t ask_for_datagram_bytes() const noexcept;

  const SocketAddress address_;
  const DestinationLimits limits_;
  std::atomic<std::size_t> datagram_bytes_;
  std::atomic<bool> one_at_a_time_{false};
  std::atomic<std::size_t> burst_bytes_;
  Pacer pacer_;
};

class DestinationDirectory {
 public:
  explicit DestinationDirectory(const DestinationLimits& limits) : limits_(limits) {}

  /// The destination of that address, known or new. Asks the kernel for the path's MTU if it is new.
  std::shared_ptr<Destination> find(const core::UdpAddress& address);

 private:
  const DestinationLimits limits_;
  std::mutex mutex_;
  std::map<SocketAddress, std::weak_ptr<Destination>> known_;
};

}  // namespace sft::udp
