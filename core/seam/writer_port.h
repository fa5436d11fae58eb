// The sending end of a transport, for one writer. There are two kinds, because samples leave a process in two
// ways that have little in common:
//
//   LendingWriter   Samples lie in memory that the transport lends, and readers look at that memory. So a
//                   sample can only be sent from a loan, it is there once for all readers, and what is held
//                   back for a late reader is kept by whoever retains samples.
//   NetworkWriter   Samples travel as bytes, from any memory. So each reader can be sent its own fields, late
//                   readers are given their history apart from all others, and small samples can share
//                   datagrams.
//
// The publisher (core/publish) needs to know which kind it talks to, and no more: another shared memory is a
// LendingWriter, a relay or another network is a NetworkWriter.
//
// Ownership. A port belongs to one writer, and may outlive the transport that opened it: it then answers
// SendStatus::lost_port. Nothing that a port is given refers to the caller once the call has returned, except
// samples, whose handles share their memory.
//
// Threads. The publisher's thread is whichever thread publishes, one at a time. It calls send(),
// set_timeout() and whatever else is marked with its name. All else is called by the node's agent thread,
// except what is marked "any thread". Both threads may call at the same time.
#pragma once

#include <cassert>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/seam/address.h"
#include "core/seam/delivery.h"
#include "core/seam/route.h"
#include "core/seam/sample_buffer.h"
#include "core/sync/thread_annotations.h"
#include "sft/type_support.h"

namespace sft::core {

struct WriterSpec {
  EndpointId id = 0;
  const TypeSupport* type = nullptr;  ///< outlives the port
  /// The writer keeps samples for late readers. False: LendingWriter::begin_with() is never called.
  bool retains = true;
  /// send() may wait for so long until what is sent reliably costs no reader an older sample.
  std::chrono::nanoseconds max_blocking{0};
  std::uint64_t max_bytes_per_s = 0;  ///< over a network, to all readers together; 0: no limit
  bool asynchronous = false;          ///< PublisherOptions
  /// A NetworkWriter counts in this book what becomes of samples, on the pages of
  /// DeliveryBook::Teller::network. Null: nobody asks.
  std::shared_ptr<DeliveryBook> book{};
};

enum class SendStatus : std::uint8_t {
  sent,       ///< handed over for every route
  displaced,  ///< handed over, but a reader that was waited for had no room in the end, and lost its oldest
              ///< sample
  dropped,    ///< at least one route did not get it (queue full, socket error); counted by the port
  lost_port,  ///< the transport is gone; the agent has been told through Transport::poll
};

class WriterPort {
 public:
  virtual ~WriterPort() = default;

  /// Sends an encoded sample to the routes in force whose gates it passes; the gates were asked on this
  /// thread before. The caller may go on reading the sample while it keeps a handle, but may write into it
  /// only if nobody else has one. Waits for readers as WriterSpec says. The mask of every route must be a
  /// subset of sample->mask. Called by the publisher's thread.
  virtual SendStatus send(const SampleHandle& sample) noexcept = 0;

  /// Limits what send() waits from now on, together with the limit of WriterSpec. Called by the publisher's
  /// thread.
  virtual void set_timeout(std::chrono::nanoseconds at_most) noexcept = 0;

  /// Replaces the routes. The publisher's thread goes on with the earlier ones until the next sample. A
  /// reader without a route gets nothing, also if it is attached.
  virtual void set_routes(std::vector<Route> routes) = 0;
};

/// A writer whose samples lie in memory of the transport.
class LendingWriter : public WriterPort {
 public:
  /// Memory for a sample of `bytes` in all (header, index, body); empty if there is none now. Owner, data and
  /// capacity are set, and the header is a fresh one. Called by the publisher's thread.
  virtual SampleHandle loan(std::size_t bytes) noexcept = 0;
  /// Returns the largest loan that can ever succeed, so that the caller can tell why one failed. May be
  /// called by any thread.
  virtual std::size_t largest_loan_bytes() const noexcept = 0;
  /// True if send() can take the sample: this port lent it, and it was not sent yet. Called by the
  /// publisher's thread.
  virtual bool can_send(const SampleBuffer& sample) const noexcept = 0;
  /// True if this port lent the sample, sent or not. May be called by any thread.
  virtual bool owns(const SampleBuffer& sample) const noexcept = 0;

  /// The rest of the time that the last send() might have waited. Called by the publisher's thread.
  virtual std::chrono::nanoseconds time_left() const noexcept = 0;

  /// The reason why that reader, although it is attached, cannot be told here that a sample has come, and
  /// must be served otherwise. Empty if it can be told. The agent asks before the reader gets a route, and
  /// again later while there is a reason.
  virtual std::string why_unreachable(const Route& to) = 0;

  // The hand-over to a late reader. A route with `history` is to such a reader: from it all samples are held
  // back until begin_with() was called, and they have to be among what the writer retains by then.

  /// The number of samples that were held back, if that reader waits. The agent asks before it looks at the
  /// retained samples. Nothing if the reader does not wait, or does not wait yet.
  virtual std::optional<std::uint64_t> held_back(EndpointId reader) noexcept = 0;
  /// Sends these samples, which the port owns(), to that one reader, and from then on whatever send() sends.
  /// False if that is not possible right now, or if more than `held_back` samples were held back by now: then
  /// look at the retained samples again.
  virtual bool begin_with(const Route& to, const std::vector<SampleHandle>& retained,
                          std::uint64_t held_back) = 0;
};

/// The routes that a sample is sent by.
enum class Reach : std::uint8_t {
  usual_routes,
  fallback_routes_too,  ///< also by those of readers that could not be served where they usually are
};

/// The time that the samples of a batch may wait for readers.
enum class BatchTimeout : std::uint8_t {
  fresh,     ///< all of them together as long as one sample may
  continued  ///< what the batch before has left of that
};

class Transmission;
class Batch;

/// A writer whose samples travel as bytes. For Clang, it is held like a lock as long as a batch lasts.
class SFT_CAPABILITY("batch") NetworkWriter : public WriterPort {
 public:
  /// A sample is about to be made, and gates are about to be asked about it: the sample goes by the routes
  /// that are in force now, and deliveries are counted by them from here on. A transmission that is let go of
  /// was of a sample that nobody wanted. Called by the publisher's thread.
  [[nodiscard]] Transmission begin() noexcept;

  /// The samples that are sent while the batch lasts need not leave at once, so that small ones share
  /// datagrams. One batch at a time. Called by the publisher's thread.
  [[nodiscard]] Batch batch(BatchTimeout timeout) noexcept SFT_ACQUIRE();

  /// True if samples may be sent of which copies are postponed (SampleBuffer::postponed). The port then
  /// completes what it gives to other threads; of the rest some may never be copied, so that such a sample is
  /// of no use to others. Always the same answer. May be called by any thread.
  virtual bool takes_postponed() const noexcept = 0;

  // In between the publisher is inside a call that serves readers on this host by another port: it makes a
  // sample, sends it, or waits for them. Threads of this port that are busy with something large leave the
  // processor to it and to these readers. Called by the publisher's thread.
  virtual void begin_local_turn() noexcept {}
  virtual void end_local_turn() noexcept {}

  // History. A route with `history` is served apart: what is sent to it names its reader, and waits until
  // send_history() was called for it. The route may become one without.

  /// Sends these samples to the reader of one such route of those in force, once, and then what waited for
  /// it.
  virtual void send_history(const Route& to, std::vector<SampleHandle> samples) = 0;
  /// True if all that was sent to the reader of such a route has left.
  virtual bool history_sent(EndpointId reader) noexcept = 0;

  // For status(). May be called by any thread.

  struct Counters {
    std::uint64_t bytes_sent = 0;  ///< payload and headers of ours handed to the system, over all routes
    /// Samples that send() took and that were not sent after all, counted for each destination that missed
    /// one.
    std::uint64_t dropped = 0;
  };
  virtual Counters counters() const noexcept = 0;
  /// The readers with which a reader shares what is sent, or the reason why it shares with nobody. Empty
  /// where that is no question.
  virtual std::string multicast(EndpointId reader) const = 0;
  /// What is wrong with the path to a reader that is served: its host does not answer, so that nothing is
  /// sent, or long datagrams do not arrive there. Empty if nothing is.
  virtual std::string path_trouble(EndpointId reader) const = 0;

 private:
  friend class Transmission;
  friend class Batch;

  // Transmission and Batch call these, and keep their order.
  virtual void begin_sample() noexcept = 0;
  /// Sends by the routes of the last begin_sample().
  virtual SendStatus send_begun(const SampleHandle& sample, Reach reach) noexcept = 0;
  virtual void miss_begun() noexcept = 0;
  virtual void hold(BatchTimeout timeout) noexcept = 0;
  virtual std::size_t flush() noexcept = 0;
};

/// One sample on its way: begun, and then sent, or missed, or let go of. The publisher's thread; must not
/// outlive its port, and ends before the next one begins. Clang refuses a second end of the same transmission
/// (-Wconsumed), and a second batch while one lasts (-Wthread-safety); other compilers leave that to
/// assertions.
class [[nodiscard]] SFT_USED_ONCE Transmission {
 public:
  Transmission(Transmission&& other) noexcept : port_(std::exchange(other.port_, nullptr)) {}
  Transmission& operator=(Transmission&&) = delete;

  /// Does what WriterPort::send() does, by the routes that were in force when the transmission began.
  SendStatus send(const SampleHandle& sample, Reach reach = Reach::usual_routes) && noexcept SFT_USES {
    return take().send_begun(sample, reach);
  }
  /// The sample could not be made: those on the usual routes whose gates it passes miss it.
  void miss() && noexcept SFT_USES { take().miss_begun(); }

 private:
  friend class NetworkWriter;
  explicit Transmission(NetworkWriter& port) noexcept : port_(&port) {}
  NetworkWriter& take() noexcept {
    assert(port_ != nullptr);
    return *std::exchange(port_, nullptr);
  }

  NetworkWriter* port_;
};

/// Samples that may share datagrams: from NetworkWriter::batch() to the end of this. The publisher's thread;
/// must not outlive its port.
class [[nodiscard]] SFT_SCOPED_CAPABILITY Batch {
 public:
  Batch(Batch&& other) noexcept : port_(std::exchange(other.port_, nullptr)) {}
  Batch& operator=(Batch&&) = delete;
  ~Batch() SFT_RELEASE() {
    if (port_ != nullptr) port_->flush();
  }

  /// Sends what was held. Returns how many of these samples did not get to each route.
  std::size_t flush() && noexcept {
    assert(port_ != nullptr);
    return std::exchange(port_, nullptr)->flush();
  }

 private:
  friend class NetworkWriter;
  explicit Batch(NetworkWriter& port) noexcept : port_(&port) {}

  NetworkWriter* port_;
};

inline Transmission NetworkWriter::begin() noexcept {
  begin_sample();
  return Transmission(*this);
}

inline Batch NetworkWriter::batch(BatchTimeout timeout) noexcept SFT_NO_THREAD_SAFETY_ANALYSIS {
  hold(timeout);
  return Batch(*this);
}

}  // namespace sft::core
