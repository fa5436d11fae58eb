// The seam between the core and the ways a sample can travel. Shared memory and UDP are each one Transport;
// the core decides who is served by which (core/negotiation/negotiation.h) and never asks which one it talks
// to.
//
// Threads. Everything is called from the node's agent thread except WriterPort::loan, begin, include_spares,
// hold, flush, send, can_send and miss (the publisher's thread), ReaderPort::take and take_of (any thread,
// one at a time), receive and interrupt (any thread), and what counts or describes (bytes_sent, dropped,
// discarded, held_too_many, lost_unnoticed, description, counters) and, for UDP, open_writer and open_reader
// (any thread); set_routes, connect, disconnect and accept may run at the same time as these. Listeners are
// called from threads of the transport, and from those in receive().
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "core/seam/address.h"
#include "core/seam/reader_port.h"
#include "core/seam/writer_port.h"
#include "sft/status.h"
#include "sft/result.h"

namespace sft::core {

using sft::TransportKind;

enum class Availability : std::uint8_t { ready, starting, unavailable };

class Transport {
 public:
  virtual ~Transport() = default;
  /// The largest body that it carries.
  virtual std::size_t max_sample_bytes() const noexcept = 0;
  /// A reader's port keeps no more samples of a writer, whatever depth it asks for.
  virtual std::uint32_t max_depth() const noexcept { return std::numeric_limits<std::uint32_t>::max(); }

  /// Looks after the transport (starts or finds its daemon, notices its death) and tells its state; called
  /// often, from the agent, and returns at once. When the answer leaves `ready`, ports of before are dead:
  /// destroy and reopen them.
  virtual Availability poll(std::chrono::steady_clock::time_point now) = 0;
  /// One sentence on the state: how it works ("io_uring, GRO"), or why it does not and what to do.
  virtual std::string description() const = 0;
  /// Parts of that, for tools. Any thread.
  virtual bool uses_io_uring() const { return false; }
  virtual bool lacks_daemon() const { return false; }  ///< none is running, and this node starts none
  /// Known while shared memory is ready; never for UDP.
  virtual HostToken host_token() const { return {}; }
  /// False where this user may only read what others write: open_writer then fails.
  virtual bool may_write() const { return true; }
  /// Where readers of this node are reached, best first; empty for shared memory (readers have doorbells).
  /// They change as interfaces come and go.
  virtual std::vector<UdpAddress> addresses() const { return {}; }
  /// The networks that others can be reached in directly; empty for shared memory.
  virtual std::vector<Link> links() const { return {}; }
  /// Whether these two may be others than when this was asked last. From the agent; returns at once.
  virtual bool network_changed() noexcept { return true; }

  virtual Result<std::unique_ptr<WriterPort>> open_writer(const WriterSpec& spec) = 0;
  virtual Result<std::unique_ptr<ReaderPort>> open_reader(const ReaderSpec& spec) = 0;

  /// Counted since open: datagrams or samples that were refused, by reason. For tools and tests.
  struct Counters {
    std::uint64_t malformed = 0;   ///< bytes that are not what they claim to be
    std::uint64_t unknown = 0;     ///< from writers that nobody here reads
    std::uint64_t incomplete = 0;  ///< samples of which a part never came
    std::uint64_t over_limit = 0;  ///< dropped to stay within a limit
    /// Answers of nothing that was sent, or from others than was sent to; marks of nobody who is read here.
    std::uint64_t disbelieved = 0;
  };
  virtual Counters counters() const noexcept { return {}; }
};

}  // namespace sft::core
