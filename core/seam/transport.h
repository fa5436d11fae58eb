// The seam between the core and the ways a sample can travel. There are two kinds of transports, because two
// processes either look at the same memory or send each other bytes:
//
//   SharedMemory  Readers on this host look at samples where their writer made them. It needs a daemon that
//                 owns the memory, it can be lost and come back, and it is asked for ports only while it is
//                 ready. Readers are woken by doorbells.
//   Network       Readers anywhere are sent bytes, at addresses that the node announces.
//
// The core decides who is served by which (core/negotiation/negotiation.h), and uses each kind for what only
// that kind can do (writer_port.h, reader_port.h); which transport it is that lies behind, it never asks.
// Whoever adds a transport derives from one of both kinds, opens it in sft/open.cpp, and runs the conformance
// suite on it (tests/conformance/conformance.md): tests/conformance/fake_transport is a Network to begin
// with.
//
// Ownership. The node owns the transport. Ports may outlive it; they do nothing then.
//
// Threads. The node's agent thread calls everything, except what is marked "any thread". Threads of the
// transport call nothing of the core but ArrivalListener and BufferOwner.
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

  /// poll() is called at least as often, also while nothing happens.
  static constexpr std::chrono::milliseconds poll_pause_max{1000};
  /// Looks after the transport (starts or finds its daemon, notices its death) and tells its state; called
  /// often, and returns at once. When the answer leaves `ready`, ports of before are dead: destroy them and
  /// open others. What had come by a BorrowingReader can still be taken until it is destroyed, which should
  /// be soon, since the memory is not free before.
  virtual Availability poll(std::chrono::steady_clock::time_point now) = 0;
  /// The largest body that it carries. Any thread.
  virtual std::size_t max_sample_bytes() const noexcept = 0;
  /// One sentence on the state: how it works ("io_uring, GRO"), or why it does not and what to do. Any
  /// thread.
  virtual std::string description() const = 0;

  /// Counted since open: datagrams or samples that were refused, by reason. For tools and tests.
  struct Counters {
    std::uint64_t malformed = 0;   ///< bytes that are not what they claim to be
    std::uint64_t unknown = 0;     ///< from writers that nobody here reads
    std::uint64_t incomplete = 0;  ///< samples of which a part never came
    std::uint64_t over_limit = 0;  ///< dropped to stay within a limit
    /// Answers to nothing that was sent, or from others than was sent to; marks of nobody who is read here.
    std::uint64_t rejected = 0;
  };
  /// Any thread.
  virtual Counters counters() const noexcept = 0;
};

class SharedMemory : public Transport {
 public:
  /// May ask a daemon, and wait for a moment. Fails with Errc::unavailable if the daemon has not answered by
  /// then.
  virtual Result<std::unique_ptr<LendingWriter>> open_writer(const WriterSpec& spec) = 0;
  virtual Result<std::unique_ptr<BorrowingReader>> open_reader(const ReaderSpec& spec) = 0;

  /// Processes with the same token see the same memory. Known while the transport is ready.
  virtual HostToken host_token() const = 0;
  /// True if the daemon was asked for a port, and will probably answer soon. The caller repeats a call that
  /// has failed, which has the port once the daemon has answered.
  virtual bool awaits_answer() const { return false; }
  /// False if this user may only read what others write: open_writer then fails.
  virtual bool may_write() const = 0;
  /// True if no daemon is running, and this node starts none. Any thread.
  virtual bool lacks_daemon() const = 0;
  /// A reader's port keeps no more samples of a writer, whatever depth it asks for. Any thread.
  virtual std::uint32_t max_depth() const noexcept = 0;
};

/// NodeStatus::quick_paths where none is used, for the same reason.
inline std::vector<NodeStatus::QuickPath> no_quick_paths(const std::string& why_not) {
  return {{"io_uring", why_not}, {"GSO", why_not}, {"GRO", why_not}, {"huge pages", why_not}};
}

class Network : public Transport {
 public:
  /// Any thread.
  virtual Result<std::unique_ptr<NetworkWriter>> open_writer(const WriterSpec& spec) = 0;
  /// Any thread.
  virtual Result<std::unique_ptr<NetworkReader>> open_reader(const ReaderSpec& spec) = 0;

  /// Returns when poll() wants to be called again; Time::max() if that has time. Asked after poll(), and
  /// after ports were told of other readers.
  virtual std::chrono::steady_clock::time_point next_poll() const = 0;

  /// The addresses at which readers of this node are reached, best first. They change as interfaces come and
  /// go. Any thread.
  virtual std::vector<UdpAddress> addresses() const = 0;
  /// The networks that others can be reached in directly. They change, too. Any thread.
  virtual std::vector<Link> links() const = 0;
  /// True if these two may be others than when this was asked last. Returns at once.
  virtual bool network_changed() noexcept = 0;
  /// Wakes the thread that is in NetworkReader::receive(): its doorbell has been rung by something else than
  /// this network. Any thread, also in a signal handler.
  virtual void wake_receiver() noexcept = 0;
  /// Something that the user should know of the network.
  struct Remark {
    LogLevel level = LogLevel::info;
    std::string text{};
  };
  /// Returns what has become so since the last call, for the log. Asked after poll().
  virtual std::vector<Remark> take_remarks() { return {}; }
  /// Sets the fields of status() that only this network can know. Any thread.
  virtual void add_to(NodeStatus& status) const = 0;
};

}  // namespace sft::core
