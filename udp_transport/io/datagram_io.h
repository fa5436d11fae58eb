// The interfaces by which the protocol sends and receives datagrams. They are implemented by io_uring
// (uring_io.h) and by plain socket calls (socket_io.h). Tests wrap an implementation in decorators that
// lose, delay, repeat or swap datagrams.
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
  /// Called before the datagrams of each receive call. All of them count as received at `now`.
  virtual void begin(ArrivalTime now) noexcept = 0;
  /// Processes one datagram. `bytes` refers to memory of the receiver, and is valid only during the call.
  virtual void datagram(std::span<const std::byte> bytes, const SocketAddress& from) noexcept = 0;
  virtual void end() noexcept = 0;

 protected:
  ~DatagramSink() = default;
};

/// A source of datagrams. All functions must be called by the first thread that calls receive(), unless a
/// function allows other threads.
class DatagramReceiver {
 public:
  using Time = std::chrono::steady_clock::time_point;
  virtual ~DatagramReceiver() = default;

  /// Waits until there are datagrams, the deadline has passed or wake() was called. Hands the datagrams to
  /// the sink. Polls for the time `spin` before it sleeps. Returns false if the receiver can never receive
  /// again.
  virtual bool receive(DatagramSink& sink, Time deadline, std::chrono::nanoseconds spin) noexcept = 0;
  /// Makes the present call of receive() return, or the next call if there is no present one. Any thread may
  /// call this.
  virtual void wake() noexcept = 0;
  /// Cancels what would keep the port in use in the kernel. Must be the last call.
  virtual void finish() noexcept = 0;

  /// Hands the next datagrams to the sink without waiting. Returns false if there are none. Any thread may
  /// call this, but not while another thread is in this function or in receive().
  virtual bool receive_now(DatagramSink& sink) noexcept = 0;
  /// Hands the next datagrams that were sent to multicast groups to the sink, without waiting. Returns false
  /// if there are none. These datagrams come to a separate socket.
  virtual bool receive_from_groups(DatagramSink& sink) noexcept = 0;
  /// Descriptors for poll(2). `datagrams` is readable while there are datagrams. `wake` is readable after a
  /// call of wake() until a thread reads it.
  struct Descriptors {
    int datagrams;
    int wake;
  };
  virtual Descriptors descriptors() const noexcept = 0;

  /// Returns the reason why plain socket calls are used, if the system has refused the quicker way
  /// (io_uring) since this receiver was opened; else empty. Any thread may call this.
  virtual std::string fell_back() const { return {}; }
};

/// Datagrams for one address. `parts` has their bytes in sequence. All datagrams but the last have the
/// length `segment_bytes`.
struct OutgoingBatch {
  std::span<const iovec> parts;
  std::uint16_t segment_bytes = 0;  ///< length of all datagrams but the last; 0 if there is only one
};

enum class SendOutcome : std::uint8_t {
  sent,
  would_wait,   ///< the send buffer is full
  too_long,     ///< the path carries only shorter datagrams
  no_segments,  ///< the interface accepts only one datagram at a time
  failed,
};

/// A connection to one address. Each connection has its own send buffer, unless there are very many
/// connections. So datagrams that wait for one address do not fill the send buffer of other addresses.
class Connection {
 public:
  virtual ~Connection() = default;

  struct Sent {
    std::size_t batches = 0;                  ///< number of sent batches, counted from the first one
    SendOutcome outcome = SendOutcome::sent;  ///< outcome of the batch after the sent ones, if there is one
    /// True if an ICMP error has come for an earlier datagram: its host has no socket with that port, or a
    /// router does not know its host.
    bool refused = false;
  };
  /// Sends the batches in order, each as a whole. Stops at the first batch that cannot be sent. Never waits.
  /// Any thread may call this.
  virtual Sent try_send(std::span<const OutgoingBatch> batches) noexcept = 0;

  /// From now on, the datagrams of this connection have a lower priority than those of other connections, if
  /// the device supports priorities.
  virtual void carry_bulk() noexcept {}

  /// Looks up the path again. Called after a refusal, or when routes or the host's own addresses have
  /// changed. Any thread may call this.
  virtual void reconnect() noexcept = 0;
  /// Connects to another address of the same remote socket. Any thread may call this.
  virtual void redirect(const SocketAddress& to) noexcept = 0;

  /// Makes the next await() return when the send buffer has room. Called after the outcome `would_wait`, by
  /// the thread that calls await().
  virtual void wait_for_room() noexcept = 0;
  /// Returns true if wait_for_room() was called, and await() has not found room in the send buffer since
  /// then. Called by the thread that calls await().
  virtual bool full() const noexcept = 0;
};

inline SendOutcome send_one(Connection& by, std::span<const std::byte> datagram) noexcept {
  // The cast is safe, because the datagram is only read.
  const iovec part{const_cast<std::byte*>(datagram.data()), datagram.size()};
  const OutgoingBatch batch{{&part, 1}, 0};
  return by.try_send({&batch, 1}).outcome;
}

class DatagramSender {
 public:
  virtual ~DatagramSender() = default;

  /// Makes a connection. It may outlive the sender, but wait_for_room() must not be called after the
  /// sender's end. Any thread may call this.
  virtual std::unique_ptr<Connection> connect(const SocketAddress& to) = 0;
  /// Connects to a multicast group, on the link where this host has the address `own`.
  virtual std::unique_ptr<Connection> connect_group(const SocketAddress& group, const SocketAddress& own) = 0;

  /// Sends one datagram without a connection, through the receiving socket. The datagram is dropped if it
  /// cannot be sent at once. Any thread may call this.
  virtual void send_to(const SocketAddress& to, std::span<const std::byte> datagram) noexcept = 0;

  /// Returns the port of a socket that receives only answers to sent datagrams. Returns 0 if there is no
  /// such socket. Then answers have to be sent to the socket that receives samples.
  virtual std::uint16_t answer_port() const noexcept { return 0; }
  struct Answer {
    std::size_t bytes = 0;  ///< length of the answer; 0: no answer has come
    SocketAddress from{};
  };
  /// Copies the next answer (an ack or a report) into `to`, without waiting. Called by the thread that calls
  /// await().
  virtual Answer take_answer([[maybe_unused]] std::span<std::byte> to) noexcept { return {}; }

  /// Waits until a waiting connection has room, an answer has come, the deadline has passed or wake() was
  /// called. Must be called by only one thread. Waiting connections must not be destroyed meanwhile.
  virtual void await(std::chrono::steady_clock::time_point deadline) noexcept = 0;
  /// Makes the present call of await() return, or the next call if there is no present one. Any thread may
  /// call this.
  virtual void wake() noexcept = 0;
};

struct DatagramIo {
  std::unique_ptr<DatagramReceiver> receiver;
  std::unique_ptr<DatagramSender> sender;
  std::string description;        ///< part of a sentence, such as "io_uring with GRO and GSO"
  std::string why_no_io_uring{};  ///< the reason why io_uring is not used; empty if it is used
};

}  // namespace sft::udp
