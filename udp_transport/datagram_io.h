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

namespace sft::udp {

struct SocketAddress {
  std::uint32_t ipv4 = 0;  ///< host byte order
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
  virtual void datagram(std::span<const std::byte> bytes, SocketAddress from) noexcept = 0;
  virtual void end() noexcept = 0;

 protected:
  ~DatagramSink() = default;
};

/// Used by one thread, the first that calls receive(), except wake().
class DatagramReceiver {
 public:
  virtual ~DatagramReceiver() = default;

  /// Waits until there are datagrams, the deadline has passed or wake() was called, and hands over what is
  /// there. False if it can never receive again.
  virtual bool receive(DatagramSink& sink, std::chrono::steady_clock::time_point deadline) noexcept = 0;
  /// Makes the present receive() return, or the next one. Any thread.
  virtual void wake() noexcept = 0;
  /// The last call: leaves nothing behind in the kernel that would hold the port.
  virtual void finish() noexcept = 0;
};

/// Datagrams for one address, laid end to end in `parts`; all of `segment_bytes` but the last.
struct OutgoingBatch {
  SocketAddress to;
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

class DatagramSender {
 public:
  virtual ~DatagramSender() = default;

  /// Never waits. Any thread.
  virtual SendOutcome try_send(const OutgoingBatch& batch) noexcept = 0;

  /// Waits for room in the send buffer; when it returns the bytes are no longer needed. Returns the first
  /// outcome that is not `sent`, after which some of the later batches may have been sent. One thread at a
  /// time, always the same.
  virtual SendOutcome send(std::span<const OutgoingBatch> batches) noexcept = 0;

  /// Makes send() give up, now and from now on. Any thread.
  virtual void stop() noexcept = 0;
  /// The last call, by the thread that called send().
  virtual void finish() noexcept = 0;
};

struct DatagramIo {
  std::unique_ptr<DatagramReceiver> receiver;
  std::unique_ptr<DatagramSender> sender;
  std::string description;  ///< part of a sentence: "io_uring with GRO and GSO"
};

}  // namespace sft::udp
