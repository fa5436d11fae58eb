// The sending end of a transport, for one writer. There are two kinds, because samples leave a process in two
// ways that have little in common:
//
//   LendingWriter   Samples lie in memory that the transport lends, and readers read that memory. So a
//                   sample can only be sent from a loan, and exists once for all readers. The publisher's
//                   history keeps the samples that are held back for a late reader.
//   NetworkWriter   Samples are sent as bytes, from any memory. So each reader can get its own fields, late
//                   readers get their history separately from all others, and small samples can share
//                   datagrams.
//
// The publisher (core/publish) needs to know only which kind it uses: another shared memory is a
// LendingWriter, a relay or another network is a NetworkWriter.
//
// Ownership. A port belongs to one writer, and may outlive the transport that opened it. From then on it
// returns SendStatus::lost_port. When a call has returned, the port keeps no reference to its arguments,
// except for samples, whose handles share their memory.
//
// Threads. "The publisher's thread" is the thread that publishes at present; there is one at a time. It calls
// send(), set_timeout() and the functions that are marked so. The node's agent thread calls all others,
// except those marked "any thread". Both threads may call at the same time.
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
  /// True: the writer keeps samples for late readers. False: LendingWriter::begin_with() is never called.
  bool retains = true;
  /// The longest time for which send() waits until reliable readers have room, so that no such reader loses
  /// an older sample.
  std::chrono::nanoseconds max_blocking{0};
  std::uint64_t max_bytes_per_s = 0;  ///< the limit for the network, for all readers together; 0: no limit
  bool asynchronous = false;          ///< PublisherOptions::asynchronous
  /// The book in which a NetworkWriter counts sent and lost samples, on the pages of
  /// DeliveryBook::Origin::network. Null: the counts are not needed.
  std::shared_ptr<DeliveryBook> book{};
};

enum class SendStatus : std::uint8_t {
  sent,  ///< the sample was passed on for every route
  /// The sample was passed on, but a reader still had no room after the wait, and lost its oldest sample.
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

  /// Sets a further limit for the time that send() waits from now on, besides the limit of WriterSpec. Called
  /// by the publisher's thread.
  virtual void set_timeout(std::chrono::nanoseconds at_most) noexcept = 0;

  /// Replaces the routes. The publisher's thread uses the earlier routes until the next sample. A reader
  /// without a route gets no samples, even if it is attached.
  virtual void set_routes(std::vector<Route> routes) = 0;
};

/// A writer whose samples lie in memory of the transport.
class LendingWriter : public WriterPort {
 public:
  /// Lends memory for a sample of `bytes` in all (header, index, body). The handle is empty if there is no
  /// memory at present. Owner, data and capacity are set, and the header is a new one. Called by the
  /// publisher's thread.
  virtual SampleHandle loan(std::size_t bytes) noexcept = 0;
  /// Returns the size in bytes of the largest loan that can ever succeed. With it the caller can tell if a
  /// failed loan was too large. Any thread.
  virtual std::size_t largest_loan_bytes() const noexcept = 0;
  /// Returns true if send() can take the sample: this port has lent it, and it was not sent yet. Called by
  /// the publisher's thread.
  virtual bool can_send(const SampleBuffer& sample) const noexcept = 0;
  /// Returns true if this port has lent the sample, whether it was sent or not. Any thread.
  virtual bool owns(const SampleBuffer& sample) const noexcept = 0;

  /// Returns the remainder of the time that the last send() was allowed to wait. Called by the publisher's
  /// thread.
  virtual std::chrono::nanoseconds time_left() const noexcept = 0;

  /// Returns the reason why the reader of this route, although it is attached, cannot be notified of samples
  /// in this memory, and must be served otherwise. Returns an empty text if the reader can be notified. The
  /// agent calls this before the reader gets a route, and again later while there is a reason.
  virtual std::string why_unreachable(const Route& to) = 0;

  // Late readers. A route with `history` leads to a late reader. All samples are held back from that reader
  // until begin_with() is called. The writer must keep the samples that are held back.

  /// Returns the number of samples that were held back, or nothing if the reader does not wait for its
  /// history at present. The agent calls this before it reads the history.
  virtual std::optional<std::uint64_t> held_back(EndpointId reader) noexcept = 0;
  /// Sends `retained`, samples which the port owns(), to that reader only. From then on the reader gets each
  /// sample that send() sends. Returns false if this is not possible at present, or if more samples than
  /// `held_back` have been held back by now. In the latter case the caller must read the history again.
  virtual bool begin_with(const Route& to, const std::vector<SampleHandle>& retained,
                          std::uint64_t held_back) = 0;
};

/// The routes by which a sample is sent.
enum class Reach : std::uint8_t {
  usual_routes,
  fallback_routes_too,  ///< the fallback routes, too, since shared memory did not take the sample
};

/// The time that the samples of a batch may wait for readers.
enum class BatchTimeout : std::uint8_t {
  fresh,     ///< all samples of the batch together may wait as long as one sample may
  continued  ///< all samples of the batch together may wait for the remaining time of the previous batch
};

class Transmission;
class Batch;

/// A writer whose samples are sent as bytes. The class is a capability for Clang: a thread holds it like a
/// lock while its batch lasts.
class SFT_CAPABILITY("batch") NetworkWriter : public WriterPort {
 public:
  /// Begins the transmission of a sample, before gates are asked about it and before it is encoded. The
  /// sample goes by the routes that are in force now, and deliveries are counted by these routes from here
  /// on. If no reader wants the sample, the transmission is simply destroyed. Called by the publisher's
  /// thread.
  [[nodiscard]] Transmission begin() noexcept;

  /// Begins a batch. Samples that are sent during the batch need not leave at once, so that small samples
  /// share datagrams. There is one batch at a time. Called by the publisher's thread.
  [[nodiscard]] Batch batch(BatchTimeout timeout) noexcept SFT_ACQUIRE();

  /// Returns true if send() takes samples with postponed copies (SampleBuffer::postponed). The port completes
  /// such a sample before it passes the sample to other threads. Otherwise parts of the sample may never be
  /// copied, so that it must not be used elsewhere. The result never changes. Any thread.
  virtual bool takes_postponed() const noexcept = 0;

  // Between these two calls the publisher serves readers on this host by another port: it makes a sample,
  // sends it, or waits for the readers. Meanwhile threads of this port that send large samples leave the
  // processor to the publisher and to these readers. Called by the publisher's thread.
  virtual void begin_local_turn() noexcept {}
  virtual void end_local_turn() noexcept {}

  // History. A route with `history` is served separately: samples that are sent by the route name its reader,
  // and wait until send_history() was called for the reader. The route may later be replaced by one without
  // `history`.

  /// Sends `samples` once to the reader of such a route in force, and then the samples that waited for this
  /// call.
  virtual void send_history(const Route& to, std::vector<SampleHandle> samples) = 0;
  /// Returns true if all samples that were sent to the reader of such a route have left this process.
  virtual bool history_sent(EndpointId reader) noexcept = 0;

  // The counts for status(). Any thread.

  struct Counters {
    /// The bytes of payload and SFT headers that were passed to the system, over all routes.
    std::uint64_t bytes_sent = 0;
    /// Samples that send() took and that were not sent later. A sample counts once for each destination that
    /// missed it.
    std::uint64_t dropped = 0;
  };
  virtual Counters counters() const noexcept = 0;
  /// Names the readers that share the multicast datagrams of a reader, or says why it shares none. Returns an
  /// empty text if multicast is not considered for the reader.
  virtual std::string multicast(EndpointId reader) const = 0;
  /// Returns the trouble with the path to a reader that is served: its host does not answer, so that no
  /// samples are sent, or long datagrams do not arrive there. Returns an empty text if there is no trouble.
  virtual std::string path_trouble(EndpointId reader) const = 0;

 private:
  friend class Transmission;
  friend class Batch;

  // The functions that Transmission and Batch call. These classes ensure the order of the calls.
  virtual void begin_sample() noexcept = 0;
  /// Sends by the routes of the last begin_sample().
  virtual SendStatus send_begun(const SampleHandle& sample, Reach reach) noexcept = 0;
  virtual void miss_begun() noexcept = 0;
  virtual void hold(BatchTimeout timeout) noexcept = 0;
  virtual std::size_t flush() noexcept = 0;
};

/// The transmission of one sample: it is begun, and then the sample is sent, missed or abandoned. Used by the
/// publisher's thread. A transmission must not outlive its port, and must end before the next one begins.
/// Clang refuses a second end of the same transmission (-Wconsumed), and a second batch while one lasts
/// (-Wthread-safety). With other compilers, assertions detect these mistakes.
class [[nodiscard]] SFT_USED_ONCE Transmission {
 public:
  Transmission(Transmission&& other) noexcept : port_(std::exchange(other.port_, nullptr)) {}
  Transmission& operator=(Transmission&&) = delete;

  /// Does what WriterPort::send() does, by the routes that were in force when the transmission began.
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

  /// Sends the samples that were held. Returns the number of samples that were not sent by all of their
  /// routes.
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
