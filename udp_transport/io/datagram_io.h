// The seam below the protocol: how datagrams leave and enter the process. It is implemented by io_uring
// (uring_io.h) and by plain socket calls (socket_io.h). Tests put decorators around either, which lose,
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
  /// Precedes the datagrams of one receive call, which count as received at one time.
  virtual void begin(ArrivalTime now) noexcept = 0;
  /// The bytes belong to the receiver and are valid during the call.
  virtual void datagram(std::span<const std::byte> bytes, const SocketAddress& from) noexcept = 0;
  virtual void end() noexcept = 0;

 protected:
  ~DatagramSink() = default;
};

/// Used by one thread, the first that calls receive(), unless a function says otherwise.
class DatagramReceiver {
 public:
  using Time = std::chrono::steady_clock::time_point;
  virtual ~DatagramReceiver() = default;

  /// Waits until there are datagrams, the deadline has passed or wake() was called, and hands the datagrams
  /// over. Keeps the core busy for `spin` before it sleeps. Returns false if it can never receive again.
  virtual bool receive(DatagramSink& sink, Time deadline, std::chrono::nanoseconds spin) noexcept = 0;
  /// Makes the present receive() return, or the next one. Any thread.
  virtual void wake() noexcept = 0;
  /// Called last. Leaves nothing behind in the kernel that would hold the port.
  virtual void finish() noexcept = 0;

  /// Hands over the next datagrams without waiting. Returns false if there are none. Any thread, while no
  /// other one is in this function or in receive().
  virtual bool receive_now(DatagramSink& sink) noexcept = 0;
  /// Hands over the next datagrams to multicast groups, as receive_now() does. They come to a socket of
  /// their own.
  virtual bool receive_from_groups(DatagramSink& sink) noexcept = 0;
  /// Descriptors for poll(2). `datagrams` is readable while there are datagrams, `wake` from wake() until
  /// it is read.
  struct Descriptors {
    int datagrams;
    int wake;
  };
  virtual Descriptors descriptors() const noexcept = 0;

  /// Returns why plain socket calls are used now, if the system has refused the quicker way (io_uring)
  /// since this receiver was opened; else empty. Any thread.
  virtual std::string fell_back() const { return {}; }
};

/// Datagrams for one address, laid end to end in `parts`. All but the last have `segment_bytes` bytes.
struct OutgoingBatch {
  std::span<const iovec> parts;
  std::uint16_t segment_bytes = 0;  ///< length of all datagrams but the last; 0 if there is only one
};

enum class SendOutcome : std::uint8_t {
  sent,
  would_wait,   ///< the send buffer is full
  too_long,     ///< the path takes only shorter datagrams
  no_segments,  ///< the interface takes only one datagram at a time
  failed,
};

/// A connection to one address. Each has a send buffer of its own, as long as there are not very many, so
/// that datagrams that cannot leave for one address take no room from others.
class Connection {
 public:
  virtual ~Connection() = default;

  struct Sent {
    std::size_t batches = 0;                  ///< number of batches sent, in their order
    SendOutcome outcome = SendOutcome::sent;  ///< outcome of the batch after these, if there is one
    /// True if, after an earlier datagram, the host there has said that no socket has that port, or a
    /// router has said that there is no such host.
    bool refused = false;
  };
  /// Sends each batch as a whole, up to the first one that cannot be sent. Never waits. Any thread.
  virtual Sent try_send(std::span<const OutgoingBatch> batches) noexcept = 0;

  /// Lets other connections go first from now on, if the device has a choice.
  virtual void carry_bulk() noexcept {}

  /// Looks up the path again: after a refusal, or if routes or the host's own addresses change. Any thread.
  virtual void reconnect() noexcept = 0;
  /// Connects to another address of the same socket. Any thread.
  virtual void redirect(const SocketAddress& to) noexcept = 0;

  /// Called after `would_wait`: makes the next await() return once there is room. The thread that calls
  /// await().
  virtual void wait_for_room() noexcept = 0;
  /// Returns true if no await() since wait_for_room() has found room. The thread that calls await().
  virtual bool full() const noexcept = 0;
};

inline SendOutcome send_one(Connection& by, std::span<const std::byte> datagram) noexcept {
  const iovec part{const_cast<std::byte*>(datagram.data()), datagram.size()};  // the datagram is only read
  const OutgoingBatch batch{{&part, 1}, 0};
  return by.try_send({&batch, 1}).outcome;
}

class DatagramSender {
 public:
  virtual ~DatagramSender() = default;

  /// Makes a connection. It may outlive the sender, but must not wait for room then. Any thread.
  virtual std::unique_ptr<Connection> connect(const SocketAddress& to) = 0;
  /// Connects to a multicast group, on the link where this host has the address `own`.
  virtual std::unique_ptr<Connection> connect_group(const SocketAddress& group, const SocketAddress& own) = 0;

  /// Sends one datagram without a connection, through the receiving socket, either at once or not at all.
  /// Any thread.
  virtual void send_to(const SocketAddress& to, std::span<const std::byte> datagram) noexcept = 0;

  /// Returns the port of a socket that receives only answers to what was sent. 0: there is none, and
  /// answers have to go to the socket that receives samples.
  virtual std::uint16_t answer_port() const noexcept { return 0; }
  struct Answer {
    std::size_t bytes = 0;  ///< length of the answer; 0: none has come
    SocketAddress from{};
  };
  /// Takes the next answer, without waiting. Called by the thread that calls await().
  virtual Answer take_answer([[maybe_unused]] std::span<std::byte> to) noexcept { return {}; }

  /// Waits until a connection that waits for room has some, an answer has come, the deadline has passed or
  /// wake() was called. Used by one thread. Connections that wait must not be destroyed meanwhile.
  virtual void await(std::chrono::steady_clock::time_point deadline) noexcept = 0;
  /// Makes the present await() return, or the next one. Any thread.
  virtual void wake() noexcept = 0;
};

struct DatagramIo {
  std::unique_ptr<DatagramReceiver> receiver;
  std::unique_ptr<DatagramSender> sender;
  std::string description;        ///< part of a sentence, such as "io_uring with GRO and GSO"
  std::string why_no_io_uring{};  ///< why io_uring is not used; empty if it is
};

}  // namespace sft::udp
