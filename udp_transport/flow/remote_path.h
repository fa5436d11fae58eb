// The path to a remote socket: the present address of the socket, further addresses from which its answers
// have come, and the maximum length of datagrams that the path carries. Any thread may call the functions.
//
// The class makes no system calls. Callers pass in the kernel's answers about the path.
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

  /// The maximum number of further addresses of the receiver that are kept. They are the addresses from
  /// which the latest answers came.
  static constexpr std::size_t also_at_max = 4;

  /// `kernel_says` is the length in bytes of the longest datagram that the kernel sends to the address.
  RemotePath(const SocketAddress& address, std::size_t kernel_says);

  SocketAddress address() const;
  /// Returns true if a datagram from that address can come from the receiver: we send to that address, or
  /// the receiver has reported from it.
  bool is_at(const core::IpAddress& ip) const;
  /// Notes that the receiver has reported from that address. Either its host has several addresses, or a
  /// router on the path translates addresses.
  void learn(const core::IpAddress& ip);

  /// Changes the address to which datagrams are sent. Returns false if it is the present address already.
  /// The length of datagrams stays that of the former path until measure_anew() is called.
  bool move_to(const SocketAddress& address) noexcept;
  /// Discards what was learnt about the length of datagrams on the former path.
  void measure_anew(const SocketAddress& address, std::size_t kernel_says) noexcept;

  std::size_t datagram_bytes() const { return datagram_bytes_.load(std::memory_order_relaxed); }
  /// Returns the length above which datagrams do not arrive although the kernel sends them; 0 if no such
  /// limit is known.
  std::size_t limited_to() const { return limited_to_.load(std::memory_order_relaxed); }
  /// Returns a sentence about that limit; empty if no limit is known.
  std::string limit_in_words() const;
  /// Returns the sentence that says that the limit has ended.
  std::string no_limit_in_words() const;
  /// Returns a sentence that says that the receiver does not answer, and one that says that it does again.
  std::string silence_in_words() const;
  std::string no_silence_in_words() const;
  /// Returns true if arrived() should be called when long datagrams arrive (PathMtu::is_uncertain()).
  bool length_is_uncertain() const { return length_is_uncertain_.load(std::memory_order_relaxed); }
  /// Takes the kernel's answer about the path to `asked`. Ignores it if the socket has moved to another
  /// address meanwhile.
  void learn_length(const SocketAddress& asked, std::size_t kernel_says) noexcept;
  // The following two functions note what the receiver has reported about datagrams of that length: that
  // they were lost, or that they arrived (PathMtu).
  void were_lost(std::size_t length, Time now) noexcept;
  void arrived(std::size_t length, Time now) noexcept;
  /// Called regularly. Tries longer datagrams if it is time, since the path may have changed and carry them
  /// now.
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
