// The path to a remote socket: the present address of the socket, further addresses that its answers have
// come from, and the length of datagrams that the path takes. Any thread may call the functions.
//
// The class makes no system call: callers pass in the kernel's answers about the path.
#pragma once

#include <atomic>
#include <cstddef>
#include <deque>
#include <string>

#include "core/platform/ip_address.h"
#include "core/sync/lock_order.h"
#include "core/sync/mutex.h"
#include "udp_transport/flow/path_mtu.h"
#include "udp_transport/io/datagram_io.h"

namespace sft::udp {

class RemotePath {
 public:
  using Time = PathMtu::Time;

  /// The number of further addresses of the receiver that are kept: those that the latest answers came
  /// from.
  static constexpr std::size_t also_at_max = 4;

  /// `kernel_says` is the length of the longest datagram that the kernel sends there.
  RemotePath(const SocketAddress& address, std::size_t kernel_says);

  SocketAddress address() const;
  /// Returns true if a datagram from that address can be the receiver's: it is the address that we send to,
  /// or the receiver has reported from it.
  bool is_at(const core::IpAddress& ip) const;
  /// Notes that the receiver has reported from that address. Either its host has several addresses, or a
  /// router on the path translates addresses.
  void learn(const core::IpAddress& ip);

  /// Sends to that address from now on. Returns false if that is the present address already. Lengths are
  /// those of the former path until measure_anew().
  bool move_to(const SocketAddress& address) noexcept;
  /// Discards what was learnt about lengths on another path.
  void measure_anew(const SocketAddress& address, std::size_t kernel_says) noexcept;

  std::size_t datagram_bytes() const { return datagram_bytes_.load(std::memory_order_relaxed); }
  /// Returns the limit, if longer datagrams do not arrive although the kernel would send them; 0 if no such
  /// limit is known.
  std::size_t limited_to() const { return limited_to_.load(std::memory_order_relaxed); }
  /// Returns the limit in a sentence; empty if there is none.
  std::string limit_in_words() const;
  /// Returns the sentence that says that there is no such limit any more.
  std::string no_limit_in_words() const;
  /// Returns true if arrived() should be called when long datagrams arrive (PathMtu::is_uncertain()).
  bool length_is_uncertain() const { return length_is_uncertain_.load(std::memory_order_relaxed); }
  /// Takes the kernel's answer about the path to `asked`. The answer is ignored if the socket has moved
  /// meanwhile.
  void learn_length(const SocketAddress& asked, std::size_t kernel_says) noexcept;
  // The following two functions note that the receiver has reported if datagrams of that length arrived
  // (PathMtu).
  void were_lost(std::size_t length, Time now) noexcept;
  void arrived(std::size_t length, Time now) noexcept;
  /// Called from time to time: tries longer datagrams, since the path may take them by now.
  void look_after(Time now) noexcept;

 private:
  void publish_length() noexcept SFT_REQUIRES(mutex_);

  mutable core::Mutex mutex_ SFT_ACQUIRED_AFTER(core::lock_order::queues)
      SFT_ACQUIRED_BEFORE(core::lock_order::facts);
  SocketAddress address_ SFT_GUARDED_BY(mutex_);
  std::deque<core::IpAddress> also_at_ SFT_GUARDED_BY(mutex_);
  PathMtu mtu_ SFT_GUARDED_BY(mutex_);
  std::atomic<std::size_t> datagram_bytes_;
  std::atomic<std::size_t> limited_to_{0};
  std::atomic<bool> length_is_uncertain_{false};
};

}  // namespace sft::udp
