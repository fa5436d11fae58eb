// One publisher without its message type: encodes each sample once and hands it to the ports that have
// readers. The work is done by its parts: SampleMaker makes samples, Dispatch sends them, LateReaders gives
// those that come late what was retained. This class tells them of each other and tells the program of
// readers.
//
// publish(), publish_cdr(), loan() and commit() are called by one thread at a time, the publisher's; what is
// marked so by the agent; all else by anybody.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

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
    /// Where these two are called; null: where they are due.
    CallbackThread* callbacks = nullptr;
    /// Called where the program asserts its liveliness: any thread, posts and returns.
    std::function<void()> asserted{};
    /// Called with the fault of a message that was refused, now and then: the publisher's thread, posts and
    /// returns.
    std::function<void(const std::string& why)> refused = [](const std::string&) {};
    std::chrono::nanoseconds max_blocking{0};
    /// The publisher counts in this book what became of samples; so does its port to the network.
    std::shared_ptr<DeliveryBook> book = std::make_shared<DeliveryBook>();
  };

  /// `heap` lends memory while nobody reads in shared memory; `network` is null where the publisher rules it
  /// out.
  PublisherCore(Spec spec, std::shared_ptr<BufferPool> heap, std::shared_ptr<NetworkWriter> network);

  PublishStatus publish(const void* value);
  /// Publishes `count` values, each `stride` bytes behind the one before.
  PublishedSpan publish(const void* values, std::size_t count, std::size_t stride);
  Result<PublishStatus> publish_cdr(std::span<const std::byte> bytes);
  Result<SampleHandle> loan(const void* prototype, std::span<const detail::Reservation> reservations,
                            detail::ReservedMemory memory);
  /// `has_gaps`: sequences of it were shortened where they lie.
  PublishStatus commit(SampleHandle sample, bool has_gaps);

  /// The fault of the last message that publish() refused. The publisher's thread.
  const std::string& why_invalid() const { return maker_.why_invalid(); }

  void assert_liveliness();

  /// After it returns no callback runs any more, except for one in which it is called itself.
  void close();

  PublisherStatus status() const;
  /// Until so many readers are served, or the time is over; tells which. Any thread but the agent's.
  bool wait_for_readers(std::size_t count, std::chrono::nanoseconds timeout) const;
  PublisherStatus::Diverted diverted() const { return dispatch_.diverted(); }
  const TypeSupport& type() const { return *spec_.type; }
  EndpointId id() const { return spec_.id; }
  const Spec& spec() const { return spec_; }
  PostedCall<Event>& events() { return events_; }

  // The agent's thread.

  /// Puts a new division of readers between the ports in force. `memory` is null while there is no shared
  /// memory, and `vanilla` while no unmodified DDS reader is served.
  void serve(Serving serving, std::shared_ptr<LendingWriter> memory,
             std::shared_ptr<VanillaPort> vanilla = nullptr);
  /// Only what status() says of readers has changed. A request with another number and nothing new in it is
  /// no change to tell the program of.
  void show(std::vector<PublisherStatus::Reader> readers);

  /// The fate of the publisher's samples for one reader.
  Delivered delivered(EndpointId reader) const { return spec_.book->of(reader); }

  // The signs of life that the program gave, from which status() tells whether the publisher keeps its
  // promises.
  OfferMonitor::Signs signs() const;
  /// Counts samples that went to all of its routes, so that it is a lower bound.
  Progress progress() const;
  /// Makes the next assertion of the program be told again.
  void listen_for_assertions() { assertion_reported_.store(false, std::memory_order_relaxed); }
  /// Returns true if status() differs by it.
  bool keeps_promises(std::uint64_t deadlines_missed, bool alive);
  /// True if all that was for a late reader alone has left.
  bool history_sent(EndpointId reader) const { return late_readers_.history_sent(reader); }
  bool retains() const { return history_ != nullptr; }
  void expire_history();
  /// To late readers in shared memory, as soon as they can be given it.
  void give_history() { late_readers_.give_history(); }

 private:
  PublishStatus publish_one(const Dispatch::Call& call, const void* value, std::int64_t stamp_ns,
                            std::chrono::nanoseconds& timeout);
  PublishedSpan publish_some(const std::byte* values, std::size_t count, std::size_t stride,
                             BatchTimeout share, std::chrono::nanoseconds& timeout);
  /// Returns how many readers are served.
  std::size_t served() const SFT_REQUIRES(status_mutex_);

  const Spec spec_;
  const std::shared_ptr<NetworkWriter> network_;  ///< null where the publisher rules it out
  const std::unique_ptr<History> history_;        ///< null unless durability asks for it
  SampleMaker maker_;                             ///< of the publisher's thread
  Dispatch dispatch_;
  LateReaders late_readers_;  ///< of the agent's thread

  std::atomic<std::uint64_t> asserted_{0};
  std::atomic<bool> assertion_reported_{false};
  std::atomic<std::uint64_t> deadlines_missed_{0};
  std::atomic<bool> alive_{true};
  PostedCall<Event> events_;
  PostedCall<PublisherStatus> readers_changed_;

  mutable Mutex status_mutex_ SFT_ACQUIRED_AFTER(lock_order::endpoints)
      SFT_ACQUIRED_BEFORE(lock_order::endpoint);
  mutable Condition readers_known_;  ///< that they may be others than before
  std::vector<PublisherStatus::Reader> readers_ SFT_GUARDED_BY(status_mutex_);
  std::shared_ptr<const VanillaPort> vanilla_ SFT_GUARDED_BY(status_mutex_);
  FieldMask encoded_ SFT_GUARDED_BY(status_mutex_);  ///< the fields that are encoded at present
};

}  // namespace sft::core
