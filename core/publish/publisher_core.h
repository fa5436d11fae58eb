// One publisher without its message type: encodes each sample once and passes it to the ports that have
// readers. Its parts do the work: SampleMaker makes samples, Dispatch sends them, LateReaders gives
// retained samples to late readers. This class connects these parts, and reports changes of the readers to
// the program.
//
// publish(), loan(), commit() and those for CDR are called by one thread at a time, the publisher's thread.
// The agent's thread calls the functions that are marked so. Any thread may call the others.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/control/control.h"
#include "core/negotiation/qos_monitor.h"
#include "core/negotiation/serving.h"
#include "core/publish/dispatch.h"
#include "core/publish/history.h"
#include "core/publish/late_readers.h"
#include "core/publish/sample_maker.h"
#include "core/report/posted_call.h"
#include "core/seam/buffer_pool.h"
#include "core/seam/delivery.h"
#include "core/seam/writer_port.h"
#include "core/sync/lock_order.h"
#include "core/sync/mutex.h"
#include "sft/detail/untyped.h"

namespace sft::core {

/// Larger than usual: each way to publish has a function of its own here, beside those of the agent's thread.
class PublisherCore {
 public:
  struct Spec {
    EndpointId id = 0;
    std::string topic;
    const TypeSupport* type = nullptr;
    std::size_t max_sample_bytes = 0;
    Qos qos{};
    std::function<void(const PublisherStatus&)> on_readers_changed{};
    Event::Callback on_event{};
    /// The thread that calls the two functions above; null: these functions are called at once, on the
    /// thread that causes the call.
    CallbackThread* callbacks = nullptr;
    /// Called by any thread when the program asserts its liveliness. The function must only post a task.
    std::function<void()> asserted{};
    /// Called by the publisher's thread when a message is refused, at most once per second. `why` is the
    /// reason. The function must only post a task.
    std::function<void(const std::string& why)> refused = [](const std::string&) {};
    std::chrono::nanoseconds max_blocking{0};
    /// The book in which the publisher and its network port count sent, withheld and lost samples.
    std::shared_ptr<DeliveryBook> book = std::make_shared<DeliveryBook>();
  };

  /// `heap` lends memory while no reader uses shared memory. `network` is null if the publisher must not use
  /// the network.
  PublisherCore(Spec spec, std::shared_ptr<BufferPool> heap, std::shared_ptr<NetworkWriter> network);

  /// Publishes a message that is in a struct of its own, or in the generated one.
  PublishStatus publish(const detail::Message& message);
  PublishStatus publish(const void* value) { return publish({spec_.type->type(), value}); }
  /// Publishes `count` values, which lie at distances of `stride` bytes.
  PublishedSpan publish(const void* values, std::size_t count, std::size_t stride);
  /// `stamp_ns` is the time of publication; 0: the present time.
  Result<PublishStatus> publish_cdr(std::span<const std::byte> bytes, std::int64_t stamp_ns = 0);
  Result<SampleHandle> loan(const void* prototype, std::span<const detail::Reservation> reservations,
                            detail::ReservedMemory memory);
  /// Publishes a loan. `has_gaps`: sequences of the loan were shortened, and the unused bytes after them
  /// have not been removed yet.
  PublishStatus commit(SampleHandle sample, bool has_gaps);
  /// Lends memory for a body that the program encodes, and publishes it.
  Result<SampleHandle> loan_cdr(std::size_t body_bytes);
  Result<PublishStatus> commit_cdr(SampleHandle sample);

  /// Returns the reason of the last refusal of a message by publish(). Called by the publisher's thread.
  const std::string& why_invalid() const { return maker_.why_invalid(); }

  void assert_liveliness();

  /// Ends callbacks. When it returns, no callback is running any more, except for a callback that itself
  /// called close().
  void close();

  PublisherStatus status() const;
  /// Waits until `count` readers are served, and then returns true. Returns false if the timeout has
  /// passed. Any thread except the agent's may call this.
  bool wait_for_readers(std::size_t count, std::chrono::nanoseconds timeout) const;
  PublisherStatus::Diverted diverted() const { return dispatch_.diverted(); }
  const TypeSupport& type() const { return *spec_.type; }
  EndpointId id() const { return spec_.id; }
  const Spec& spec() const { return spec_; }
  PostedCall<Event>& events() { return events_; }

  // The functions for the agent's thread.

  /// Puts the routes of all ports in force. `memory` is null while there is no shared memory, and `vanilla`
  /// while no unmodified DDS reader is served.
  void serve(Serving serving, std::shared_ptr<LendingWriter> memory,
             std::shared_ptr<VanillaPort> vanilla = nullptr);
  /// Called when the status of readers has changed, but no route has. Calls on_readers_changed, unless only
  /// the numbers of requests differ.
  void show(std::vector<PublisherStatus::Reader> readers);
  /// Called when the number of readers of the port for unmodified readers has changed.
  void vanilla_readers_changed();

  /// Returns the counts of the publisher's samples for one reader.
  Delivered delivered(EndpointId reader) const { return spec_.book->of(reader); }

  /// Returns how often the program has published, and how often it has asserted liveliness. From these
  /// numbers OfferMonitor decides if the publisher keeps its deadline and its lease.
  OfferMonitor::Signs signs() const;
  /// Returns the progress of the publisher. Only samples that were sent by all routes count, so that the
  /// result is a lower bound.
  Progress progress() const;
  /// Restores the notification by Spec::asserted, which is called only once until this function is called.
  void listen_for_assertions() { assertion_reported_.store(false, std::memory_order_relaxed); }
  /// Sets the missed deadlines and the liveliness that status() reports. Returns true if one of them has
  /// changed.
  bool keeps_promises(std::uint64_t deadlines_missed, bool alive);
  /// Returns true if all retained samples that were sent to this late reader by UDP have left this process.
  bool history_sent(EndpointId reader) const { return late_readers_.history_sent(reader); }
  bool retains() const { return history_ != nullptr; }
  void expire_history();
  /// Sends the history to late readers in shared memory that are attached and wait for it.
  void give_history() { late_readers_.give_history(); }

 private:
  PublishStatus publish_one(const Dispatch::Call& call, const detail::Message& message, std::int64_t stamp_ns,
                            std::chrono::nanoseconds& timeout);
  PublishedSpan publish_some(const std::byte* values, std::size_t count, std::size_t stride,
                             BatchTimeout share, std::chrono::nanoseconds& timeout);
  /// Returns the number of readers that are served.
  std::size_t served() const SFT_REQUIRES(status_mutex_);

  const Spec spec_;
  const std::shared_ptr<NetworkWriter> network_;  ///< null if the publisher must not use the network
  const std::unique_ptr<History> history_;        ///< null unless the publisher is durable
  SampleMaker maker_;                             ///< used by the publisher's thread
  Dispatch dispatch_;
  LateReaders late_readers_;  ///< used by the agent's thread

  std::atomic<std::uint64_t> asserted_{0};
  std::atomic<bool> assertion_reported_{false};
  std::atomic<std::uint64_t> deadlines_missed_{0};
  std::atomic<bool> alive_{true};
  PostedCall<Event> events_;
  PostedCall<PublisherStatus> readers_changed_;

  mutable Mutex status_mutex_ SFT_ACQUIRED_AFTER(lock_order::endpoints)
      SFT_ACQUIRED_BEFORE(lock_order::endpoint);
  mutable Condition readers_known_;  ///< notified when the readers may have changed
  std::vector<PublisherStatus::Reader> readers_ SFT_GUARDED_BY(status_mutex_);
  std::shared_ptr<const VanillaPort> vanilla_ SFT_GUARDED_BY(status_mutex_);
  FieldMask encoded_ SFT_GUARDED_BY(status_mutex_);  ///< the fields that are encoded into each sample at
                                                     ///< present
};

}  // namespace sft::core
