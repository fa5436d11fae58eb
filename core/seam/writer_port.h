// The sending end of a transport, for one writer. transport.h says which thread calls what.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/seam/address.h"
#include "core/seam/delivery.h"
#include "core/seam/route.h"
#include "core/seam/sample_buffer.h"
#include "sft/type_support.h"

namespace sft::core {

struct WriterSpec {
  EndpointId id = 0;
  const TypeSupport* type = nullptr;  ///< outlives the port
  bool retains = true;                ///< samples for late readers; false: begin_with() is never called
  /// send() may wait so long until what is sent reliably costs no reader an older sample.
  std::chrono::nanoseconds max_blocking{0};
  std::uint64_t max_bytes_per_s = 0;  ///< over a network, to all readers together; 0: no limit
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

}  // namespace sft::core
