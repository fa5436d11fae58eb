// The seam below the protocol: how datagrams leave and enter the process. Implemented by io_uring
// (uring_io.h) and by plain socket calls (socket_io.h); tests put decorators around either, which lose,
// delay, repeat or swap datagrams.
#pragma once

#include <sys/uio.h>

#include <chrono>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "core/platform/ip_address.h"

namespace sft::udp {

struct SocketAddress {
  core::IpAddress ip;
  std::uint16_t port = 0;
  friend auto operator<=>(const SocketAddress&, const SocketAddress&) = default;
};

struct ArrivalTime {
  std::chrono::steady_clock::time_point steady;
  std::int64_t realtime_ns = 0;
};

class DatagramSink {
 public:
  /// Datagrams follow that came in one receive call, at one time.
  virtual void begin(ArrivalTime now) noexcept = 0;
  /// The bytes are the receiver's and valid during the call.
  virtual void datagram(std::span<const std::byte> bytes, const SocketAddress& from) noexcept = 0;
  virtual void end() noexcept = 0;

 protected:
  ~DatagramSink() = default;
};

/// Used by one thread, the first that calls receive(), but where something else is said.
class DatagramReceiver {
 public:
  using Time = std::chrono::steady_clock::time_point;
  virtual ~DatagramReceiver() = default;

  /// Waits until there are datagrams, the deadline has passed or wake() was called, and hands over what is
  /// there. Keeps the core busy for `spin` before it sleeps. False if it can never receive again.
  virtual bool receive(DatagramSink& sink, Time deadline, std::chrono::nanoseconds spin) noexcept = 0;
  /// Makes the present receive() return, or the next one. Any thread.
  virtual void wake() noexcept = 0;
  /// The last call: leaves nothing behind in the kernel that would hold the port.
  virtual void finish() noexcept = 0;

  /// Hands over what came next, without waiting; false if nothing is there. Any thread, while no other is in
  /// here or in receive().
  virtual bool receive_now(DatagramSink& sink) noexcept = 0;
  /// The same, of what was sent to groups: that lies in a socket of its own.
  virtual bool receive_from_groups(DatagramSink& sink) noexcept = 0;
  /// Descriptors for poll(2): readable while there are datagrams, and after wake() until it is read.
  struct Descriptors {
    int datagrams;
    int wake;
  };
  virtual Descriptors descriptors() const noexcept = 0;

  /// The system has taken the quicker way back with which this was opened, and plain calls take its place:
  /// the reason. Empty otherwise. Any thread.
  virtual std::string fell_back() const { return {}; }
};

/// Datagrams for one address, laid end to end in `parts`; all of `segment_bytes` but the last.
struct OutgoingBatch {
  std::span<const iovec> parts;
  std::uint16_t segment_bytes = 0;  ///< 0 if there is one datagram
};

enum class SendOutcome : std::uint8_t {
  sent,
  would_wait,   ///< the send buffer is full
  too_long,     ///< the path takes shorter datagrams only
  no_segments,  ///< the way out takes one datagram at a time only
  failed,
};

/// A way to one address. As long as there are not very many, each has a send buffer of its own, so that what
/// cannot leave for one address takes no room from the others.
class Connection {
 public:
  virtual ~Connection() = default;

  struct Sent {
    std::size_t batches = 0;                  ///< the first ones
    SendOutcome outcome = SendOutcome::sent;  ///< of the one after these, if there is one
    /// True if, after an earlier datagram, the host there has said that nobody has that port, or a router has
    /// said that there is no such host.
    bool refused = false;
  };
  /// Sends each batch as a whole, up to the first that cannot be sent. Never waits. Any thread.
  virtual Sent try_send(std::span<const OutgoingBatch> batches) noexcept = 0;

  /// From now on others go first, where a device has a choice.
  virtual void carry_bulk() noexcept {}

  /// Looks for the way anew: after a refusal, for routes and the host's own addresses change. Any thread.
  virtual void reconnect() noexcept = 0;
  /// The same, to another address of the same socket. Any thread.
  virtual void redirect(const SocketAddress& to) noexcept = 0;

  /// After `would_wait`: makes the next await() return once there is room. The thread that calls await().
  virtual void wait_for_room() noexcept = 0;
  /// No await() since wait_for_room() has found room. The thread that calls await().
  virtual bool full() const noexcept = 0;
};

inline SendOutcome send_one(Connection& by, std::span<const std::byte> datagram) noexcept {
  const iovec part{const_cast<std::byte*>(datagram.data()), datagram.size()};  // it is only read
  const OutgoingBatch batch{{&part, 1}, 0};
  return by.try_send({&batch, 1}).outcome;
}

class DatagramSender {
 public:
  virtual ~DatagramSender() = default;

  /// Any thread. The connection may outlive the sender, but not be waited for then.
  virtual std::unique_ptr<Connection> connect(const SocketAddress& to) = 0;
  /// To a multicast group, on the link where this host has the address `own`.
  virtual std::unique_ptr<Connection> connect_group(const SocketAddress& group, const SocketAddress& own) = 0;

  /// Sends one datagram without a connection, through a socket that is there anyway: now or not at all. Any
  /// thread.
  virtual void send_to(const SocketAddress& to, std::span<const std::byte> datagram) noexcept = 0;

  /// The port of a socket for what comes back from those who are sent to; 0: there is none, and it has to go
  /// where this process receives.
  virtual std::uint16_t answer_port() const noexcept { return 0; }
  struct Answer {
    std::size_t bytes = 0;  ///< 0: nothing has come
    SocketAddress from{};
  };
  /// Takes what came there next, without waiting. Used by the thread that calls await().
  virtual Answer take_answer([[maybe_unused]] std::span<std::byte> to) noexcept { return {}; }

  /// Waits until a connection has the room that it waits for, an answer has come, the deadline has passed or
  /// wake() was called.
  /// Used by one thread; the connections that wait live on meanwhile.
  virtual void await(std::chrono::steady_clock::time_point deadline) noexcept = 0;
  /// Makes the present await() return, or the next one. Any thread.
  virtual void wake() noexcept = 0;
};

struct DatagramIo {
  std::unique_ptr<DatagramReceiver> receiver;
  std::unique_ptr<DatagramSender> sender;
  std::string description;        ///< part of a sentence: "io_uring with GRO and GSO"
  std::string why_no_io_uring{};  ///< empty: it is used
};

}  // namespace sft::udp
