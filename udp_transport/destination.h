// A socket of somebody's that samples are sent to, shared by all writers that serve readers behind it, and
// the way there, which can change: a socket has several addresses.
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
#include "udp_transport/path_mtu.h"

namespace sft::udp {

struct DestinationLimits {
  std::uint64_t bytes_per_s = 0;  ///< 0: none
  std::size_t datagram_bytes = datagram_bytes_max;
};

class Destination {
 public:
  Destination(const SocketAddress& address, const DestinationLimits& limits,
              std::unique_ptr<Connection> connection);

  Connection& connection() { return *connection_; }
  std::size_t datagram_bytes() const { return datagram_bytes_.load(std::memory_order_relaxed); }
  std::size_t datagrams_per_call() const;
  /// Half of what the receiving socket holds: the kernel counts more than the bytes.
  std::size_t burst_bytes() const { return burst_bytes_.load(std::memory_order_relaxed); }
  /// What the receiver announced. Less than any system grants unasked is not believed: it would never get a
  /// sample.
  void set_receive_buffer(std::uint32_t bytes);

  SocketAddress address() const;
  /// To another address of the same socket: what is on its way there goes on. Any thread.
  void move_to(const SocketAddress& address) noexcept;
  /// Counts these moves.
  std::uint32_t moves() const { return moves_.load(std::memory_order_relaxed); }

  /// Learns from a send that was refused; the next one fits, and takes the way as it is now. Any thread.
  void note(SendOutcome outcome) noexcept;

  // What the other end lets know of long datagrams (path_mtu.h). Any thread.

  bool length_in_doubt() const { return length_in_doubt_.load(std::memory_order_relaxed); }
  void long_ones_were_lost(PathMtu::Time now) noexcept;
  void long_ones_arrived(PathMtu::Time now) noexcept;

  /// From time to time, by one thread: the path may take longer datagrams by now. `anew`: it may be another
  /// one.
  void look_after(PathMtu::Time now, bool anew) noexcept;

  /// Of the sending thread alone.
  Pacer& pacer() { return pacer_; }

 private:
  static constexpr std::chrono::seconds kernel_is_asked_every{5};

  std::size_t ask_kernel(const SocketAddress& address) const noexcept;
  PathMtu path_to(const SocketAddress& address) const noexcept;
  void learn_from_kernel() noexcept;
  /// With the mutex held.
  void publish_length() noexcept;

  const DestinationLimits limits_;
  mutable std::mutex mutex_;  ///< of these two
  SocketAddress address_;
  PathMtu path_;
  PathMtu::Time kernel_asked_at_{};  ///< of the thread that looks after it
  std::atomic<bool> length_in_doubt_{false};
  std::atomic<std::uint32_t> moves_{0};
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
  /// path's MTU. Where the address says whose it is, a known one moves there. It goes, with its connection,
  /// when nobody sends there any more.
  std::shared_ptr<Destination> find(const core::UdpAddress& address);

  /// Of all that are known. `anew`: routes or own addresses have changed.
  void look_after(PathMtu::Time now, bool anew);

 private:
  const DestinationLimits limits_;
  const Connect connect_;
  std::mutex mutex_;
  /// One that has several addresses is known by its node and port, any other by its address.
  using Key = std::pair<std::uint64_t, SocketAddress>;
  static Key key_of(const core::UdpAddress& address);
  std::shared_ptr<Destination> known(const core::UdpAddress& address);
  std::map<Key, std::weak_ptr<Destination>> known_;
};

}  // namespace sft::udp
