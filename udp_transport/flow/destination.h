// A socket of somebody's that samples are sent to, shared by all writers that serve readers behind it, and
// the ways there, which can change: a socket has several addresses. At each it has to answer before it is
// sent more than a few datagrams (flow_window.h).
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <utility>

#include "core/seam/transport.h"
#include "udp_transport/flow/flow_window.h"
#include "udp_transport/flow/path_mtu.h"
#include "udp_transport/io/datagram_io.h"
#include "udp_transport/wire/datagram.h"
#include "udp_transport/wire/keyed_hash.h"

namespace sft::udp {

struct DestinationLimits {
  std::size_t datagram_bytes = datagram_bytes_max;
  std::uint16_t report_port = 0;  ///< where receivers report to; 0: they are not asked, and need not answer
  FlowLimits flow{};
};

using Connect = std::function<std::unique_ptr<Connection>(const SocketAddress&)>;

class Destination {
 public:
  using Time = FlowWindow::Time;
  using Size = FlowWindow::Size;

  /// `flow` is what its receiver will call us by, and nobody else can guess; `connect` is called again for
  /// the first large sample.
  /// Channels to it are numbered from `channels` on, which nobody else can guess either. `host`: of the
  /// address, see FlowWindow.
  Destination(const SocketAddress& address, const DestinationLimits& limits, std::uint32_t flow,
              Connect connect, std::uint32_t channels = 0, std::shared_ptr<UnprovenBudget> host = {});

  // Any thread.

  /// For what is small, and must not queue behind large samples.
  Connection& connection() { return *connection_; }
  /// Returns the connection for datagrams that must not overtake anything that was sent up to `position`.
  Connection& connection_after(std::uint64_t position);

  std::size_t datagram_bytes() const { return datagram_bytes_.load(std::memory_order_relaxed); }
  std::size_t datagrams_per_call() const;
  /// The size of the remote socket's receive buffer as announced; 0 if none was.
  std::uint32_t receive_buffer_bytes() const { return receive_buffer_bytes_.load(std::memory_order_relaxed); }
  void set_receive_buffer(std::uint32_t bytes);

  // These functions tell how much may be under way, and take what was sent; FlowWindow explains them. Any
  // thread.

  std::size_t room(Size size, Time now);
  bool takes_control(Time now);
  std::size_t batch_bytes();
  /// Notes what was sent through one of the connections. Sends the receiver a mark if one is due.
  void sent(const Connection& by, std::size_t bytes, std::size_t datagrams, Time now);
  /// The host there says that nobody has that port.
  void refused(Time now);
  /// Somebody waits for room: asks a receiver again that does not report.
  void mark(Time now);
  struct Heard {
    bool believed = false;
    bool goes_on = false;  ///< somebody waited who may go on now
  };
  /// A report that repeats one of our marks shows that the receiver is at the address that it comes from.
  [[nodiscard]] Heard hear(const FlowReport& report, const core::IpAddress& from, Time now);
  /// An ack of one of its channels came.
  void lives(Time now);
  Time next_ready(Time now);
  std::uint64_t position();
  std::uint32_t flow() const { return flow_; }
  /// The channel of that number, which counts the channels of a writer, is called by this there.
  std::uint32_t name_of_channel(std::uint32_t number) const { return channels_ + number; }
  /// The shortest of late; 0: not known.
  Time::duration round_trip();
  /// Returns true if a datagram from that address can be the receiver's word: we send there, or the receiver
  /// has reported from there.
  bool is_at(const core::IpAddress& ip) const;
  /// True if the receiver has reported, and was not silent at the last look.
  bool answers() const { return answers_.load(std::memory_order_relaxed); }
  /// True if the receiver was asked for a second and does not answer.
  bool is_mute(Time now);

  /// The sending thread: for large samples.
  Connection& bulk();
  /// The same, any thread; null before the first.
  Connection* bulk_in_use() { return bulk_in_use_.load(std::memory_order_acquire); }

  SocketAddress address() const;
  /// Moves to another address of the same socket; datagrams on their way go on. Any thread.
  void move_to(const SocketAddress& address, std::shared_ptr<UnprovenBudget> host) noexcept;
  /// Counts these moves, and the returns of a receiver that was silent: what it is told again, it is told at
  /// once.
  std::uint32_t moves() const { return moves_.load(std::memory_order_relaxed); }

  /// Learns from a send that was refused; the next one fits, and takes the way as it is now. Any thread.
  void note(SendOutcome outcome) noexcept;

  // These functions know what the other end tells about long datagrams (path_mtu.h). Any thread.

  bool length_in_doubt() const { return length_in_doubt_.load(std::memory_order_relaxed); }
  void long_ones_were_lost(PathMtu::Time now) noexcept;
  void long_ones_arrived(PathMtu::Time now) noexcept;

  /// From time to time, by one thread: the path may take longer datagrams by now. `anew`: it may be another
  /// one.
  void look_after(PathMtu::Time now, bool anew) noexcept;

 private:
  static constexpr std::chrono::seconds kernel_is_asked_every{5};

  std::size_t ask_kernel(const SocketAddress& address) const noexcept;
  PathMtu path_to(const SocketAddress& address) const noexcept;
  void learn_from_kernel() noexcept;
  /// REQUIRES: the mutex is held.
  void publish_length() noexcept;
  void reconnect() noexcept;
  void send(FlowMark mark, Time now);
  /// Returns the connection that is behind everything that was sent.
  Connection& last_in_line() {
    Connection* const bulk = bulk_in_use_.load(std::memory_order_acquire);
    return bulk == nullptr ? *connection_ : *bulk;
  }

  const DestinationLimits limits_;
  const std::uint32_t flow_;
  const std::uint32_t channels_;
  const Connect connect_;
  mutable std::mutex mutex_;  ///< of these three
  SocketAddress address_;
  std::deque<core::IpAddress> also_at_;  ///< reports have come from there
  PathMtu path_;
  PathMtu::Time kernel_asked_at_{};  ///< of the thread that looks after it
  std::atomic<bool> length_in_doubt_{false};
  std::atomic<std::uint32_t> moves_{0};
  std::atomic<std::size_t> datagram_bytes_;
  std::atomic<std::uint32_t> receive_buffer_bytes_{0};
  std::atomic<bool> one_at_a_time_{false};
  const std::unique_ptr<Connection> connection_;
  std::unique_ptr<Connection> bulk_;  ///< of the sending thread, which makes it
  std::atomic<Connection*> bulk_in_use_{nullptr};
  static constexpr std::size_t also_at_max = 4;
  void note_answers(Time now);
  void learn(const core::IpAddress& from);

  std::mutex window_mutex_;  ///< of these two
  FlowWindow window_;
  bool control_withheld_ = false;
  std::atomic<bool> answers_;
};

class DestinationDirectory {
 public:
  DestinationDirectory(const DestinationLimits& limits, Connect connect);

  /// The destination of that address, known or new: a new one is connected to, and the kernel asked for the
  /// path's MTU. Where the address says whose it is, a known one moves there. It goes, with its connection,
  /// when nobody sends there any more.
  std::shared_ptr<Destination> find(const core::UdpAddress& address);
  /// The one that reports by that number; null if there is none any more.
  std::shared_ptr<Destination> of_flow(std::uint32_t flow);

  /// Looks after all known destinations. `anew`: routes or own addresses have changed.
  void look_after(PathMtu::Time now, bool anew);

 private:
  const DestinationLimits limits_;
  const Connect connect_;
  const HashKey channel_key_;
  std::mutex mutex_;
  /// One that has several addresses is known by its node and port, any other by its address.
  using Key = std::pair<std::uint64_t, SocketAddress>;
  static Key key_of(const core::UdpAddress& address);
  std::uint32_t first_channel(const Key& key) const;
  std::shared_ptr<Destination> known(const core::UdpAddress& address);
  std::uint32_t unused_flow();
  std::map<Key, std::weak_ptr<Destination>> known_;
  UnprovenBudgets hosts_;
};

}  // namespace sft::udp
