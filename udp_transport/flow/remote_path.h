// The path to a remote socket: the address at which the socket is sent to at present, further addresses that
// its answers have come from, and the length of datagrams that the path takes. Any thread.
//
// The class makes no system call: what the kernel says of the path is given to it.
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

  /// The last few addresses that answers came from count, beside the one that is sent to.
  static constexpr std::size_t also_at_max = 4;

  /// `kernel_says`: the longest datagram, as far as the kernel knows.
  RemotePath(const SocketAddress& address, std::size_t kernel_says);

  SocketAddress address() const;
  /// Returns true if a datagram from that address can be the receiver's word: we send there, or the receiver
  /// has reported from there.
  bool is_at(const core::IpAddress& ip) const;
  /// The receiver has reported from there: its host has several addresses, or somebody on the way translates
  /// addresses.
  void learn(const core::IpAddress& ip);

  /// From now on the socket is sent to at that address. False if that is so already. Lengths are those of the
  /// former path until measure_anew().
  bool move_to(const SocketAddress& address) noexcept;
  /// Forgets what was learnt of lengths on another path.
  void measure_anew(const SocketAddress& address, std::size_t kernel_says) noexcept;

  std::size_t datagram_bytes() const { return datagram_bytes_.load(std::memory_order_relaxed); }
  /// Datagrams that are longer than this do not arrive, although the kernel would send them; 0: they do, as
  /// far as is known.
  std::size_t limited_to() const { return limited_to_.load(std::memory_order_relaxed); }
  /// The same as a sentence; empty if there is no such limit.
  std::string limit_in_words() const;
  /// Says that there is no such limit any more.
  std::string no_limit_in_words() const;
  /// True if arrived() should be called when long datagrams arrive (PathMtu::is_uncertain()).
  bool length_is_uncertain() const { return length_is_uncertain_.load(std::memory_order_relaxed); }
  /// The kernel was asked about the path to that address. Ignored if the socket has moved meanwhile.
  void learn_length(const SocketAddress& asked, std::size_t kernel_says) noexcept;
  // The receiver has reported whether datagrams of that length arrived (PathMtu).
  void were_lost(std::size_t length, Time now) noexcept;
  void arrived(std::size_t length, Time now) noexcept;
  /// From time to time: the path may take longer datagrams by now.
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
