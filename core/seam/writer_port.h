// The sending end of a transport, for one writer. There are two kinds, because samples leave a process in
// two ways that have little in common:
//
//   LendingWriter   Samples lie in memory that the transport lends, and readers read that memory. So a
//                   sample can only be sent from a loan, and exists once for all readers. The publisher's
//                   history keeps the samples that are held back for a late reader.
//   NetworkWriter   Samples are sent as bytes, from any memory. So each reader can get its own fields, late
//                   readers get their history separately from all others, and small samples can share
//                   datagrams.
//
// The publisher (core/publish) needs to know only which kind a port is. A port of another shared memory
// would be a LendingWriter, and a port of a relay or another network a NetworkWriter.
//
// Ownership. A port belongs to one writer, and may outlive the transport that opened it. After the end of
// the transport, send() returns SendStatus::lost_port. When a call has returned, the port keeps no
// reference to its arguments, except for samples, whose handles share their memory.
//
// Threads. "The publisher's thread" is the thread that publishes at present; there is one at a time. This
// thread calls send(), set_timeout() and the functions that are marked so. The node's agent thread calls
// all other functions, except those marked "any thread". Both threads may call at the same time.
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
  const TypeSupport* type = nullptr;  ///< must outlive the port
  /// True: the writer retains samples for late readers. False: LendingWriter::begin_with() is never called.
  bool retains = true;
  /// The longest time for which send() waits until the queues of reliable readers have free slots, so that
  /// no such reader loses an older sample.
  std::chrono::nanoseconds max_blocking{0};
  std::uint64_t max_bytes_per_s = 0;  ///< the maximum rate over the network in bytes per second, for all
                                      ///< readers together; 0: no limit
  std::size_t resend_bytes = std::size_t{64} << 20;  ///< PublisherOptions::resend_bytes
  std::int8_t priority = 0;                          ///< PublisherOptions::priority
  bool asynchronous = false;          ///< PublisherOptions::asynchronous
  /// The book in which a NetworkWriter counts sent and lost samples, on the pages of
  /// DeliveryBook::Origin::network. Null: the counts are not needed.
  std::shared_ptr<DeliveryBook> book{};
};

enum class SendStatus : std::uint8_t {
  sent,  ///< the sample was passed on for every route
  /// The sample was passed on, but the queue of a reader was still full after the wait, and lost its oldest
  /// sample.
  displaced,
  dropped,    ///< at least one route missed the sample (queue full, socket error), which the port has counted
  lost_port,  ///< the transport is gone; Transport::poll() reports it to the agent
};

class WriterPort {
 public:
  virtual ~WriterPort() = default;

  /// Sends an encoded sample by the routes in force whose gates it passes (Gate::passes()). The caller may
  /// still read the sample while it keeps a handle, but may write to the sample only if this is the only
  /// handle. Waits for readers as WriterSpec says. The mask of every route must be a subset of sample->mask.
  /// Called by the publisher's thread.
  virtual SendStatus send(const SampleHandle& sample) noexcept = 0;

  /// Sets a limit for the time that each later send() waits. It applies in addition to the limit of
  /// WriterSpec. Called by the publisher's thread.
  virtual void set_timeout(std::chrono::nanoseconds at_most) noexcept = 0;

  /// Replaces the routes. The publisher's thread uses the earlier routes until the next sample. A reader
  /// without a route gets no samples, even if it is attached.
  virtual void set_routes(std::vector<Route> routes) = 0;
};

/// A writer whose samples lie in memory of the transport.
class LendingWriter : public WriterPort {
 public:
  /// Lends memory for a sample of `bytes` in all (header, index, body). The handle is empty if there is no
  /// memory at present. The members owner, data and capacity are set, and the memory begins with a new
  /// header. Called by the publisher's thread.
  virtual SampleHandle loan(std::size_t bytes) noexcept = 0;
  /// Returns the size in bytes of the largest loan that can ever succeed. By it the caller can decide
  /// whether a failed loan was too large. Any thread may call this.
  virtual std::size_t largest_loan_bytes() const noexcept = 0;
  /// Returns true if this port has lent the sample and the sample was not sent yet. Only such a sample can
  /// be passed to send(). Called by the publisher's thread.
  virtual bool can_send(const SampleBuffer& sample) const noexcept = 0;
  /// Returns true if this port has lent the sample, whether it was sent or not. Any thread may call this.
  virtual bool owns(const SampleBuffer& sample) const noexcept = 0;

  /// Returns the remainder of the time that the last send() was allowed to wait. Called by the publisher's
  /// thread.
  virtual std::chrono::nanoseconds time_left() const noexcept = 0;

  /// Returns the reason why the reader of this route, although it is attached, cannot be notified of
  /// samples in this memory. Such a reader must be served by another path. Returns an empty text if the
  /// reader can be notified. The agent calls this before the reader gets a route, and again later while
  /// there is a reason.
  virtual std::string why_unreachable(const Route& to) = 0;

  // Late readers. A route with `history` leads to a late reader. The port withholds all samples from that
  // reader until begin_with() is called. Meanwhile the writer must retain these samples.

  /// Returns the number of samples that were held back from the reader, or nothing if the reader is not
  /// waiting for its history. The agent calls this before it reads the history.
  virtual std::optional<std::uint64_t> held_back(EndpointId reader) noexcept = 0;
  /// Sends `retained`, samples which the port owns(), to that reader only. From then on the reader gets
  /// each sample that send() sends. Returns false if this is not possible at present, or if more than
  /// `held_back` samples have been held back from the reader. In the second case the caller must read the
  /// history again and repeat the call.
  virtual bool begin_with(const Route& to, const std::vector<SampleHandle>& retained,
                          std::uint64_t held_back) = 0;
};

/// The routes by which a sample is sent.
enum class Reach : std::uint8_t {
  usual_routes,
  fallback_routes_too,  ///< both the usual routes and the fallback routes, since shared memory did not take
                        ///< the sample
};

/// For how long the samples of a batch may wait for readers.
enum class BatchTimeout : std::uint8_t {
  fresh,     ///< all samples of the batch together may wait as long as one sample may
  continued  ///< all samples of the batch together may wait for the remaining time of the previous batch
};

class Transmission;
class Batch;

/// A writer whose samples are sent as bytes. The class is a capability for Clang: while a thread has a
/// batch, it holds the writer like a lock.
class SFT_CAPABILITY("batch") NetworkWriter : public WriterPort {
 public:
  /// Begins the transmission of a sample, before gates are asked about it and before it is encoded. The
  /// sample will be sent by the routes that are in force now, and deliveries are counted for these routes
  /// from now on. If no reader wants the sample, the caller simply destroys the transmission. Called by the
  /// publisher's thread.
  [[nodiscard]] Transmission begin() noexcept;

  /// Begins a batch. Samples that are sent during the batch need not leave at once, so that small samples
  /// share datagrams. There must be only one batch at a time. Called by the publisher's thread.
  [[nodiscard]] Batch batch(BatchTimeout timeout) noexcept SFT_ACQUIRE();

  /// Returns true if send() takes samples with postponed copies (SampleBuffer::postponed). The port
  /// completes such a sample before it passes the sample to other threads. If such a sample is never sent,
  /// its postponed parts may never be copied, so it must not be used for anything else. The result never
  /// changes. Any thread may call this.
  virtual bool takes_postponed() const noexcept = 0;

  // Between these two calls the publisher serves readers on this host by another port: it makes a sample,
  // sends it, or waits for the readers. Meanwhile threads of this port that send large samples yield the
  // processor to the publisher and these readers. Called by the publisher's thread.
  virtual void begin_local_turn() noexcept {}
  virtual void end_local_turn() noexcept {}

  // History. A route with `history` is served separately: samples that are sent by the route contain the id
  // of its reader, and are queued until send_history() is called for the reader. The route may later be
  // replaced by one without `history`.

  /// Sends `samples` once to the reader of such a route that is in force, and then the samples that were
  /// queued for this reader.
  virtual void send_history(const Route& to, std::vector<SampleHandle> samples) = 0;
  /// Returns true if all samples that were sent to the reader of a route with `history` have left this
  /// process.
  virtual bool history_sent(EndpointId reader) noexcept = 0;

  // The counts for status(). Any thread.

  struct Counters {
    /// The bytes of payload and SFT headers that were passed to the system, over all routes.
    std::uint64_t bytes_sent = 0;
    /// The number of samples that were passed to send() and were not sent later. A sample counts once for
    /// each destination that missed it.
    std::uint64_t dropped = 0;
  };
  virtual Counters counters() const noexcept = 0;
  /// Returns text that names the readers which get the same multicast datagrams as this reader, or the
  /// reason why there are none. Returns an empty text if multicast is not considered for the reader.
  virtual std::string multicast(EndpointId reader) const = 0;
  /// Returns a text about the problem with the path to a served reader: the reader's host does not answer,
  /// so that no samples are sent, or long datagrams do not arrive there. Returns an empty text if there is
  /// no trouble.
  virtual std::string path_trouble(EndpointId reader) const = 0;

 private:
  friend class Transmission;
  friend class Batch;

  // The functions that Transmission and Batch call. These classes ensure the order of the calls.
  virtual void begin_sample() noexcept = 0;
  /// Sends the sample by the routes that were in force at the last begin_sample().
  virtual SendStatus send_begun(const SampleHandle& sample, Reach reach) noexcept = 0;
  virtual void miss_begun() noexcept = 0;
  virtual void hold(BatchTimeout timeout) noexcept = 0;
  virtual std::size_t flush() noexcept = 0;
};

/// The transmission of one sample: it begins, and then the sample is sent, counted as missed, or abandoned.
/// Used by the publisher's thread. A transmission must not outlive its port, and must end before the next
/// one begins. Clang refuses a second end of the same transmission (-Wconsumed), and a second batch while
/// one lasts (-Wthread-safety). With other compilers, assertions detect these mistakes.
class [[nodiscard]] SFT_USED_ONCE Transmission {
 public:
  Transmission(Transmission&& other) noexcept : port_(std::exchange(other.port_, nullptr)) {}
  Transmission& operator=(Transmission&&) = delete;

  /// Does the same as WriterPort::send(), but by the routes that were in force when the transmission began.
  SendStatus send(const SampleHandle& sample, Reach reach = Reach::usual_routes) && noexcept SFT_USES {
    return take().send_begun(sample, reach);
  }
  /// Called if the sample could not be made. Counts the sample as dropped for the usual routes whose gates it
  /// passes.
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

/// A batch: samples that are sent between NetworkWriter::batch() and the destruction of this object may share
/// datagrams. Used by the publisher's thread. A batch must not outlive its port.
class [[nodiscard]] SFT_SCOPED_CAPABILITY Batch {
 public:
  Batch(Batch&& other) noexcept : port_(std::exchange(other.port_, nullptr)) {}
  Batch& operator=(Batch&&) = delete;
  ~Batch() SFT_RELEASE() {
    if (port_ != nullptr) port_->flush();
  }

  /// Sends the samples that are held back for shared datagrams. Returns the number of samples that were not
  /// sent by all of their routes.
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
