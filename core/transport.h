// The seam between the core and the ways a sample can travel. Shared memory and UDP are each one Transport;
// the core decides who is served by which (core/negotiation.h) and never asks which one it talks to.
//
// Threads. Everything is called from the node's agent thread except WriterPort::loan, begin, include_spares,
// hold, flush, send, can_send and miss (the publisher's thread), ReaderPort::take and take_of (any thread,
// one at a time), receive and interrupt (any thread), and what counts or describes (bytes_sent, dropped,
// discarded, held_too_many, lost_unnoticed, description, counters) and, for UDP, open_writer and open_reader
// (any thread); set_routes, connect, disconnect and accept may run at the same time as these. Listeners are
// called from threads of the transport, and from those in receive().
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "core/delivery.h"
#include "core/ip_address.h"
#include "core/rate_gate.h"
#include "core/sample_buffer.h"
#include "sft/status.h"
#include "sft/typesupport/field_mask.h"
#include "sft/typesupport/result.h"
#include "sft/typesupport/type_support.h"

namespace sft::core {

using sft::TransportKind;
struct Doorbell;

using EndpointId = std::uint64_t;  ///< random per incarnation, never 0; datagrams carry its low 32 bits

/// Where datagrams for a reader go.
struct UdpAddress {
  IpAddress ip;
  std::uint16_t port = 0;
  std::uint32_t receive_buffer_bytes =
      0;                  ///< of the socket, as the kernel counts: a sender paces bursts by it
  bool wireless = false;  ///< the interface that has it is
  /// Whose socket it is, random per incarnation: of equal ones with equal ports, one takes the other's place.
  /// 0: it is not known what other addresses that socket has.
  std::uint64_t node = 0;
  friend bool operator==(const UdpAddress&, const UdpAddress&) = default;
};

/// One of our own addresses, and the network that it is in.
struct Link {
  IpAddress ip;  ///< a link-local one with its scope
  std::uint8_t prefix_bits = 0;
  bool running = true;  ///< its interface has a carrier
  bool wireless = false;
  friend bool operator==(const Link&, const Link&) = default;
};

/// The word that is rung when a sample for a reader was put into shared memory (core/doorbell.h).
struct DoorbellAddress {
  std::uint64_t page = 0;
  std::uint32_t slot = 0;
  friend bool operator==(const DoorbellAddress&, const DoorbellAddress&) = default;
};

using Locator = std::variant<UdpAddress, DoorbellAddress>;

/// A reader to be served, and with what. `mask` is closed.
struct Route {
  EndpointId reader = 0;
  Locator destination;
  FieldMask mask;
  std::uint32_t min_period_us = 0;         ///< the limit that it asks for; 0: none
  std::shared_ptr<const RateGate> gate{};  ///< which keeps that limit; null: every sample is for it
  /// Not 0: it is served apart from all others, from so many retained samples on.
  std::uint32_t history = 0;
  /// It is served elsewhere, and by this only as WriterPort::include_spares() says.
  bool spare = false;
  bool reliable = false;  ///< what gets lost on the way is sent again
  friend bool operator==(const Route&, const Route&) = default;
};

struct WriterSpec {
  EndpointId id = 0;
  const TypeSupport* type = nullptr;  ///< outlives the port
  bool retains = true;                ///< samples for late readers; false: begin_with() is never called
  /// send() may wait so long until what is sent reliably costs no reader an older sample.
  std::chrono::nanoseconds max_blocking{0};
  std::uint64_t max_bytes_per_s = 0;  ///< over a network, to all readers together; 0: no limit
};

/// Where a writer's node can be reached: nobody else is answered in its name.
struct Announced {
  bool known = false;  ///< false: nothing is known of it, and it is answered wherever it says
  std::vector<UdpAddress> addresses{};
  bool same_network = false;  ///< as this process: it may be reached by loopback, too
  friend bool operator==(const Announced&, const Announced&) = default;
};

/// What a reader has to know of a writer whose samples it wants.
struct Source {
  EndpointId writer = 0;
  std::size_t max_sample_bytes = 0;
  bool history_first = false;  ///< nothing of it is for the reader until something for it alone has come
  bool reliable = false;       ///< in order, and what gets lost on the way is asked for
  bool waits = false;          ///< its publisher does, for readers that do not keep up
  Announced node{};
  bool alive = true;  ///< its node answers
  friend bool operator==(const Source&, const Source&) = default;
};

/// Which samples of a writer are for a reader, where several share a destination.
struct Wanted {
  FieldMask mask;  ///< closed
  std::uint32_t min_period_us = 0;
  friend bool operator==(const Wanted&, const Wanted&) = default;
};

/// What a reader asks its writers for, or has asked for while samples may be under way under that.
struct Accepted {
  Wanted wanted;
  /// Counts up, for readers that get samples in order: once a writer has told how far it was when it knew of
  /// a request, what comes behind that is under no earlier one. 0: nobody relies on that.
  std::uint64_t request = 0;
  bool heard = false;  ///< each writer that was asked knows of it by now
};

enum class SendStatus : std::uint8_t {
  sent,       ///< handed over for every route
  displaced,  ///< the same, but a reader that was waited for had no room in the end, and lost its oldest
              ///< sample
  dropped,    ///< at least one route did not get it (queue full, socket error); counted by the port
  lost_port,  ///< the transport is gone; the agent has been told through Transport::poll
};

class WriterPort {
 public:
  virtual ~WriterPort() = default;

  /// Memory of the transport for a sample of `bytes` in all (header, index, body); empty if there is none
  /// now, and always where samples travel from any memory. Owner, data, capacity are set and the header is a
  /// fresh one.
  virtual SampleHandle loan(std::size_t bytes) noexcept {
    static_cast<void>(bytes);
    return {};
  }
  /// No loan() of more can ever succeed: for telling why one did not.
  virtual std::size_t largest_loan_bytes() const noexcept { return std::numeric_limits<std::size_t>::max(); }

  /// Sends an encoded sample to the routes in force whose gates it passes, as these say on this thread; see
  /// can_send() for where it may come from. The caller may still read the sample afterwards while it keeps a
  /// handle, but not write, unless its is the only one. Waits for readers as WriterSpec says. Every route's
  /// mask must be a subset of sample->mask.
  virtual SendStatus send(const SampleHandle& sample) noexcept = 0;

  /// Whether send() takes samples of which copies are postponed (SampleBuffer::postponed). What it gives to
  /// other threads it completes; of the rest some may never be copied, so that such a sample is of no use to
  /// others.
  virtual bool takes_postponed() const noexcept { return false; }

  /// Until flush() the samples that are sent need not leave at once, so that small ones share datagrams. All
  /// of them together wait for readers as long as one may; if it `goes_on`, with those of before.
  virtual void hold([[maybe_unused]] bool goes_on) noexcept {}
  /// Sends what was held. Returns how many of these samples did not get to each route.
  virtual std::size_t flush() noexcept { return 0; }

  /// A sample is about to be made, and gates to be asked: it goes by the routes that are in force now.
  /// Without this by those in force when it is sent.
  virtual void begin() noexcept {}
  /// The following samples are for nobody here, until begin() or send().
  virtual void rest() noexcept {}
  /// The sample that is sent next goes by spare routes, too: where it should have gone it could not.
  virtual void include_spares() noexcept {}
  /// The sample that the gates were asked about last could not be made: whom it was for misses it, but for
  /// spare routes.
  virtual void miss() noexcept {}

  /// Where to count what becomes of samples, by the pages of DeliveryBook::Teller::network. Called at most
  /// once, before anything else.
  virtual void count_in(std::shared_ptr<DeliveryBook> book) { static_cast<void>(book); }

  /// Why that reader, although it is attached, cannot be told here that a sample has come, and so must be
  /// served otherwise; empty if it can. To be asked before it gets a route, and again later while there is a
  /// reason.
  virtual std::string why_unreachable(const Route& to) {
    static_cast<void>(to);
    return {};
  }

  /// A route with `history` is served apart: what is sent to it names its reader, and waits until
  /// send_history() was called for it. It may become one without.
  virtual void set_routes(std::vector<Route> routes) = 0;
  /// Sends these to one such route of those in force, once, and then what waited for it. Where the transport
  /// cannot address a single reader nothing is sent.
  virtual void send_history(const Route& to, std::vector<SampleHandle> samples) {
    static_cast<void>(to);
    static_cast<void>(samples);
  }
  // Where what is sent cannot wait for one reader alone (shared memory) it is held back from that reader, and
  // has to be in what is retained by then.

  /// How many samples were held back, where that reader waits: to be asked before what is retained is looked
  /// at. Nothing where it does not, or not yet.
  virtual std::optional<std::uint64_t> held_back(EndpointId reader) noexcept {
    static_cast<void>(reader);
    return std::nullopt;
  }
  /// Sends these, which it holds(), to that one reader, and from then on what send() sends. False if that is
  /// not possible right now, or something was held back since: then look again.
  virtual bool begin_with(const Route& to, const std::vector<SampleHandle>& retained,
                          std::uint64_t held_back) {
    static_cast<void>(to), static_cast<void>(retained), static_cast<void>(held_back);
    return false;
  }
  /// Whether the sample lies in memory that this port lent.
  virtual bool holds(const SampleBuffer& sample) const noexcept {
    static_cast<void>(sample);
    return false;
  }
  /// Whether all that was sent to the reader of such a route has left.
  virtual bool history_sent(EndpointId reader) noexcept {
    static_cast<void>(reader);
    return true;
  }

  /// Whether send() can take this sample as it is: shared memory only carries what it lent itself.
  virtual bool can_send(const SampleBuffer& sample) const noexcept {
    static_cast<void>(sample);
    return true;
  }

  /// With whom a reader shares what is sent, or why with nobody: for status(). Empty where that is no
  /// question. Any thread.
  virtual std::string multicast(EndpointId reader) const {
    static_cast<void>(reader);
    return {};
  }

  /// Why nothing is sent to a reader that is served, for status(): its host does not answer. Empty where that
  /// is not so. Any thread.
  virtual std::string silence(EndpointId reader) const {
    static_cast<void>(reader);
    return {};
  }

  /// From now on send() waits no longer than this, and than WriterSpec says. The publisher's thread.
  virtual void be_patient(std::chrono::nanoseconds at_most) noexcept { static_cast<void>(at_most); }
  /// What the last send() has left of the time that it might have waited, of ports that carry samples in
  /// shared memory. The publisher's thread.
  virtual std::chrono::nanoseconds patience_left() const noexcept { return std::chrono::nanoseconds{0}; }

  /// Bytes of payload and headers of ours handed to the operating system so far, over all routes (0 in shared
  /// memory).
  virtual std::uint64_t bytes_sent() const noexcept = 0;

  /// Samples that send() queued and that were not sent after all, counted for each destination that missed
  /// one.
  virtual std::uint64_t dropped() const noexcept { return 0; }
};

class ArrivalListener {
 public:
  /// At least one sample can be taken. Called from a thread that receives, which does nothing else meanwhile.
  virtual void arrived() noexcept = 0;

 protected:
  ~ArrivalListener() = default;
};

struct ReaderSpec {
  EndpointId id = 0;
  const TypeSupport* type = nullptr;  ///< outlives the port
  std::uint32_t depth = 1;            ///< samples kept until taken, per writer; the oldest goes first
  ArrivalListener* listener =
      nullptr;               ///< outlives the port; not called by shared memory, where doorbells ring
  DoorbellAddress doorbell;  ///< what writers in shared memory ring for this reader
  /// Handles of one writer that may be out; take() gives no more of it then. For shared memory.
  std::uint32_t max_held = 256;
  /// All that its listener does is to ring `doorbell`, for threads in ReaderPort::receive(), which any of
  /// them may do for the others.
  bool only_waited_for = false;
  /// How long the thread that calls the listener looks for more, and keeps a core busy with it, before it
  /// sleeps.
  std::chrono::nanoseconds spin{0};
};

/// Of a thread that waits for a sample, until its reader's doorbell is rung.
struct Waiting {
  Doorbell& bell;
  std::uint32_t seen = 0;  ///< of its rings
  std::chrono::steady_clock::time_point deadline;
  std::chrono::steady_clock::time_point spin_until;  ///< keeps the core busy so long
};

/// How far a late reader is with what comes for it alone.
enum class HistoryProgress : std::uint8_t {
  awaited,  ///< nothing has come yet
  coming,
  came,  ///< nothing of it is under way any more
};

class ReaderPort {
 public:
  virtual ~ReaderPort() = default;

  /// The oldest sample not yet taken, validated so far that every getter is safe; empty if there is none.
  virtual SampleHandle take() noexcept = 0;
  /// The same, of that writer only. Where writers do not pass each other there is no need for it.
  virtual SampleHandle take_of(EndpointId writer) noexcept {
    static_cast<void>(writer);
    return {};
  }

  /// Wakes writers that wait for room that take() has made since this was called last. After take(), without
  /// a lock: it may make a system call. Any thread.
  virtual void tell_of_room() noexcept {}

  /// Begins to accept a writer's samples. In shared memory asks the daemon, with a deadline of its own.
  virtual Result<void> connect(const Source& source) = 0;
  /// Whether samples that the writer sends from now on will arrive.
  virtual bool connected(EndpointId writer) const noexcept = 0;
  /// Of a writer that was connected to with `history_first`.
  virtual HistoryProgress history(EndpointId writer) const noexcept {
    static_cast<void>(writer);
    return HistoryProgress::came;
  }
  /// Differs from what it was whenever a sample of that writer has arrived meanwhile, taken or not.
  virtual std::uint64_t arrivals(EndpointId writer) noexcept = 0;
  /// Waits on the spot where samples come in, and does the transport's receiving there, which spares what is
  /// waited for the way from one thread to another; listeners of this and other readers are called meanwhile.
  /// Spurious returns are possible. False, at once, where that cannot be: the transport has its own thread
  /// for it, and the bell will be rung. Any thread.
  virtual bool receive(const Waiting& waiting) noexcept {
    static_cast<void>(waiting);
    return false;
  }
  /// After somebody else than the transport rang the bell: whoever is in receive() looks at it. Any thread.
  virtual void interrupt() noexcept {}
  /// It has samples by another transport from now on, too, which those of this one must not be behind: the
  /// transport's own thread receives, always.
  virtual void share_reader() {}

  /// A writer that is connected has announced something else than before, or its node answers, or does not.
  /// `history_first` does not change.
  virtual void announced(const Source& source) { static_cast<void>(source); }

  /// Accepts no more of them; what has arrived can still be taken.
  virtual void disconnect(EndpointId writer) noexcept = 0;

  /// Which samples are for this reader: what it requests now, as the last, and what it requested before while
  /// such samples may be under way. Only meaningful where variants share a destination (UDP).
  virtual void accept(std::vector<Accepted> accepted) = 0;

  /// Samples that arrived whole and were thrown away: pushed out of a full queue, or malformed.
  virtual std::uint64_t discarded() const noexcept = 0;

  /// Times that as many samples of a writer were held as may be, and the next one could not be taken.
  virtual std::uint64_t held_too_many() const noexcept { return 0; }

  /// Of those discarded, samples that no gap in the sequences of those taken shows: before the first of a
  /// writer, or behind the last one of a writer that was disconnected.
  virtual std::uint64_t lost_unnoticed() const noexcept { return 0; }
};

/// Identity of the memory that co-located processes share: boot_id and the token that the daemon put into
/// /dev/shm.
struct HostToken {
  std::array<std::uint8_t, 32> bytes{};
  bool known() const { return bytes != std::array<std::uint8_t, 32>{}; }
  friend bool operator==(const HostToken&, const HostToken&) = default;
};

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
