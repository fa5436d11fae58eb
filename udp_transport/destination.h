// A socket of somebody's that samples are sent to, shared by all writers that serve readers behind it, and
// the way there.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <utility>

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
  Destination(const SocketAddress& address, const DestinationLimits& limits,
              std::unique_ptr<Connection> connection);

  const SocketAddress& address() const { return address_; }
  Connection& connection() { return *connection_; }
  std::size_t datagram_bytes() const { return datagram_bytes_.load(std::memory_order_relaxed); }
  std::size_t datagrams_per_call() const;
  /// Half of what the receiving socket holds: the kernel counts more than the bytes.
  std::size_t burst_bytes() const { return burst_bytes_.load(std::memory_order_relaxed); }
  /// What the receiver announced. Less than any system grants unasked is not believed: it would never get a
  /// sample.
  void set_receive_buffer(std::uint32_t bytes);

  /// Learns from a send that was refused; the next one fits, and takes the way as it is now. Any thread.
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
  const std::unique_ptr<Connection> connection_;
};

class DestinationDirectory {
 public:
  using Connect = std::function<std::unique_ptr<Connection>(const SocketAddress&)>;

  DestinationDirectory(const DestinationLimits& limits, Connect connect)
      : limits_(limits), connect_(std::move(connect)) {}

  /// The destination of that address, known or new: a new one is connected to, and the kernel asked for the
  /// path's MTU. It goes, with its connection, when nobody sends there any more.
  std::shared_ptr<Destination> find(const core::UdpAddress& address);

 private:
  const DestinationLimits limits_;
  const Connect connect_;
  std::mutex mutex_;
  std::map<SocketAddress, std::weak_ptr<Destination>> known_;
};

}  // namespace sft::udp
