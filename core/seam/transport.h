// The interface between the core and the transports of samples. Two processes either read the same memory
// or send each other bytes, so there are two kinds of transports:
//
//   SharedMemory  Readers on this host read samples where their writer made them. A daemon owns the memory.
//                 The memory can be lost and come back, and ports are opened only while the memory is
//                 ready. Readers are woken by doorbells.
//   Network       Bytes are sent to readers anywhere, at addresses that the node announces.
//
// The core decides which transport serves which reader (core/negotiation/negotiation.h), and uses the
// special abilities of each kind (writer_port.h, reader_port.h). It never depends on an implementation. To
// add a transport, derive a class from SharedMemory or Network, open it in sft/open.cpp, and run the
// conformance suite on it (tests/conformance/conformance.md). tests/conformance/fake_transport is an
// example of a Network to start from.
//
// Ownership. The node owns the transport. Ports may outlive the transport, but do nothing after its end.
//
// Threads. The node's agent thread calls all functions, except those marked "any thread". Threads of the
// transport call no functions of the core except those of ArrivalListener and BufferOwner.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/seam/address.h"
#include "core/seam/reader_port.h"
#include "core/seam/writer_port.h"
#include "sft/options.h"
#include "sft/result.h"
#include "sft/status.h"

namespace sft::core {

using sft::TransportKind;

enum class Availability : std::uint8_t { ready, starting, unavailable };

class Transport {
 public:
  virtual ~Transport() = default;

  /// The longest time between two calls of poll(), even while nothing happens.
  static constexpr std::chrono::milliseconds poll_pause_max{1000};
  /// Maintains the transport (starts or finds its daemon, notices the death of the daemon) and returns its
  /// state. Must be called often, and returns at once. Once the state is no longer `ready`, no port works
  /// any more: the caller must destroy the ports, and may open new ones later. Samples that have arrived at
  /// a BorrowingReader can still be taken until the reader is destroyed. The reader should be destroyed
  /// soon, since its memory is not freed before.
  virtual Availability poll(std::chrono::steady_clock::time_point now) = 0;
  /// Returns the size in bytes of the largest body that the transport can carry. Any thread may call this.
  virtual std::size_t max_sample_bytes() const noexcept = 0;
  /// Returns one sentence about the state: either the features in use ("io_uring, GRO"), or the reason why
  /// the transport does not work and the remedy. Any thread may call this.
  virtual std::string description() const = 0;

  /// Datagrams or samples that were refused since the transport was opened, by reason. For tools and tests.
  struct Counters {
    std::uint64_t malformed = 0;   ///< malformed contents
    std::uint64_t unknown = 0;     ///< datagrams of writers that no reader here is connected to
    std::uint64_t incomplete = 0;  ///< samples of which a part never arrived
    std::uint64_t over_limit = 0;  ///< samples or datagrams that were dropped to stay within a limit
    /// Answers of readers that refer to datagrams which were never sent, or were sent to another address,
    /// and flow marks (reports of a writer about what it has sent) of writers that no reader here is
    /// connected to.
    std::uint64_t rejected = 0;
  };
  /// Returns the counts. Any thread may call this.
  virtual Counters counters() const noexcept = 0;
};

class SharedMemory : public Transport {
 public:
  /// Opens a port. May send a request to a daemon, and wait a moment for the answer. Fails with
  /// Errc::unavailable if the daemon has not answered within this moment.
  virtual Result<std::unique_ptr<LendingWriter>> open_writer(const WriterSpec& spec) = 0;
  virtual Result<std::unique_ptr<BorrowingReader>> open_reader(const ReaderSpec& spec) = 0;

  /// Returns the identity of the memory, which is valid while the transport is ready. Processes with the same
  /// token share the memory.
  virtual HostToken host_token() const = 0;
  /// Returns true if the daemon was asked for a port, and will probably answer soon. The caller should then
  /// repeat the failed call, which succeeds once the daemon has answered.
  virtual bool awaits_answer() const { return false; }
  /// Returns false if the user of this process may only read samples in shared memory. In this case
  /// open_writer() fails.
  virtual bool may_write() const = 0;
  /// Returns true if no daemon is running and this node must not start one. Any thread may call this.
  virtual bool lacks_daemon() const = 0;
  /// Returns the maximum number of samples of one writer that a reader's port keeps, even if a greater
  /// depth is requested. Any thread may call this.
  virtual std::uint32_t max_depth() const noexcept = 0;
};

/// Returns the value of NodeStatus::quick_paths for a node that uses none of these paths, for the same
/// reason in each case.
inline std::vector<NodeStatus::QuickPath> no_quick_paths(const std::string& why_not) {
  return {{"io_uring", why_not}, {"GSO", why_not}, {"GRO", why_not}, {"huge pages", why_not}};
}

class Network : public Transport {
 public:
  /// Opens the port of a writer. Any thread may call this.
  virtual Result<std::unique_ptr<NetworkWriter>> open_writer(const WriterSpec& spec) = 0;
  /// Opens the port of a reader. Any thread may call this.
  virtual Result<std::unique_ptr<NetworkReader>> open_reader(const ReaderSpec& spec) = 0;

  /// Returns the time at which poll() must be called again, or Time::max() if no call is needed. Called after
  /// poll(), and after the readers of a port have changed.
  virtual std::chrono::steady_clock::time_point next_poll() const = 0;

  /// Returns the addresses at which readers of this node are reached, best first. The addresses change as
  /// interfaces appear and disappear. Any thread may call this.
  virtual std::vector<UdpAddress> addresses() const = 0;
  /// Returns the networks in which other nodes can be reached directly. These networks also change as
  /// interfaces appear and disappear. Any thread may call this.
  virtual std::vector<Link> links() const = 0;
  /// Returns true if addresses() and links() may have changed since the last call. Returns at once.
  virtual bool network_changed() noexcept = 0;
  /// Wakes the thread that is in NetworkReader::receive(). Must be called when something other than this
  /// network has rung that thread's doorbell. Any thread and any signal handler may call this.
  virtual void wake_receiver() noexcept = 0;
  /// A message about the network for the user.
  struct Remark {
    LogLevel level = LogLevel::info;
    std::string text{};
  };
  /// Returns the remarks that were made since the last call, for the log. Called after poll().
  virtual std::vector<Remark> take_remarks() { return {}; }
  /// Sets those members of `status` whose values only this network knows. Any thread may call this.
  virtual void add_to(NodeStatus& status) const = 0;
};

}  // namespace sft::core
