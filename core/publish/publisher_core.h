// One publisher without its message type: encodes each sample once and hands it to the ports that have
// readers.
//
// publish(), publish_cdr(), loan() and commit() are called by one thread at a time; serve() by the agent;
// status() by anybody.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <span>
#include <string>

#include "core/negotiation/negotiation.h"
#include "core/negotiation/qos_watch.h"
#include "core/publish/history.h"
#include "core/publish/outlets.h"
#include "core/report/event_sink.h"
#include "core/seam/buffer_pool.h"
#include "core/seam/delivery.h"
#include "core/seam/transport.h"
#include "core/sync/call_count.h"
#include "core/sync/snapshot.h"
#include "sft/detail/project.h"
#include "sft/detail/untyped.h"
#include "sft/detail/walk.h"

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
    EventCallback on_event{};
    /// Called where the program asserts its liveliness: any thread, posts and returns.
    std::function<void()> asserted{};
    std::chrono::nanoseconds max_blocking{0};
  };

  /// `heap` lends memory while nobody reads in shared memory; `udp` is null where the publisher rules it out.
  PublisherCore(Spec spec, std::shared_ptr<BufferPool> heap, std::shared_ptr<WriterPort> udp);

  PublishStatus publish(const void* value);
  /// So many values, each `stride` bytes behind the one before.
  PublishedSpan publish(const void* values, std::size_t count, std::size_t stride);
  Result<PublishStatus> publish_cdr(std::span<const std::byte> bytes);
  Result<SampleHandle> loan(const void* prototype, std::span<const detail::Reservation> reservations,
                            detail::ReservedMemory memory);
  /// `has_gaps`: sequences of it were shortened where they lie.
  PublishStatus commit(SampleHandle sample, bool has_gaps);

  /// Of the last message that publish() refused. The thread that publishes.
  const std::string& why_invalid() const { return why_invalid_; }

  void assert_liveliness();

  /// After it returns no callback runs any more, except for one in which it is called itself.
  void close();

  PublisherStatus status() const;
  /// Until so many readers are served, or the time is over; tells which. Any thread but the agent's.
  bool wait_for_readers(std::size_t count, std::chrono::nanoseconds timeout) const;
  Diverted diverted() const;
  const TypeSupport& type() const { return *spec_.type; }
  EndpointId id() const { return spec_.id; }
  const Spec& spec() const { return spec_; }
  EventSink& events() { return events_; }

  /// Puts a new division of readers between the ports in force. `shm` is null while there is no shared
  /// memory.
  void serve(Serving serving, std::shared_ptr<WriterPort> shm);
  /// Only what status() says of readers has changed. A request with another number and nothing new in it is
  /// no change to tell the program of.
  void show(std::vector<ReaderStatus> readers);

  /// What became of its samples for one reader.
  Delivered delivered(EndpointId reader) const { return book_->of(reader); }

  // The agent's: what the program did, and for status() how it keeps its promises.
  OfferWatch::Signs signs() const;
  /// Of samples that went to all of its routes: a lower bound.
  Progress progress() const;
  /// From here on the next assertion of the program is told again.
  void listen_for_assertions() { assertion_told_.store(false, std::memory_order_relaxed); }
  /// Whether status() differs by it.
  bool keeps_promises(std::uint64_t deadlines_missed, bool alive);
  /// Whether all that was for a late reader alone has left.
  bool history_sent(EndpointId reader) const { return udp_ == nullptr || udp_->history_sent(reader); }
  bool retains() const { return history_ != nullptr; }
  void expire_history();
  /// To late readers in shared memory, as soon as they can be given it.
  void give_history();

 private:
  std::vector<Route> take_latecomers(const Serving& serving);
  bool changes_over(const Serving& serving);
  /// Those in force, by which is counted from here on.
  const Outlets& outlets() noexcept {
    const Outlets* outlets = outlets_.load();
    if (outlets != counted_) [[unlikely]]
      turn_to(*outlets);
    return *outlets;
  }
  void turn_to(const Outlets& outlets) noexcept;
  std::uint32_t whole_bytes(const void* value, std::uint32_t encoded_bytes, std::int64_t stamp_ns) noexcept;
  bool admit(const Outlets& outlets, std::int64_t stamp_ns) const noexcept;
  std::shared_ptr<Outlets> outlets_for(const Serving& serving, std::shared_ptr<WriterPort> shm) const;
  PublishedSpan publish_some(const std::byte* values, std::size_t count, std::size_t stride, bool goes_on);
  PublishStatus encode_and_send(const Outlets& outlets, const void* value, std::int64_t stamp_ns);
  [[gnu::cold, gnu::noinline]] PublishStatus refuse(const void* value, const FieldMask& mask);
  Error fault_of(const void* value, const FieldMask& mask,
                 std::span<const detail::Reservation> reservations = {}) const;
  PublishStatus no_memory(const Outlets& outlets, std::uint32_t body_bytes) noexcept;
  void count_refusal(const Outlets& outlets, std::uint32_t body_bytes) noexcept;
  tl::unexpected<Error> malformed(detail::WalkStatus why) const;
  SampleHandle await_chunk(const Outlets& outlets, std::size_t bytes) noexcept;
  SampleHandle take_heap(std::size_t bytes) noexcept;
  SampleHandle lend(const Outlets& outlets, std::uint32_t body_bytes) noexcept;
  void fill_header(SampleBuffer& buffer, const FieldMask& mask, std::uint32_t body_bytes) noexcept;
  PublishStatus send(const Outlets& before, const SampleHandle& sample, std::int64_t stamp_ns) noexcept;
  PublishStatus withhold() noexcept;
  PublishStatus close_gaps(SampleBuffer& sample) noexcept;
  SendStatus send_to_shm(const Outlets& outlets, const SampleHandle& sample) noexcept;
  void note_sent_by_udp_alone(const SampleBuffer& sample) noexcept;
  PublishStatus divert(const Outlets& outlets, const SampleHandle& sample) noexcept;
  SampleHandle copy_to_shm(WriterPort& shm, const SampleHandle& sample) const noexcept;
  void give_history(const Serving& serving, const std::vector<Route>& latecomers);
  bool give_history(WriterPort& shm, const Route& route);
  std::vector<SampleHandle> retained_in(WriterPort& shm, std::uint32_t count);

  const Spec spec_;
  const FieldMask full_;
  const detail::ProjectionPlan onto_itself_;  ///< closes the gaps of a loan that was shortened
  detail::Projection closing_;
  const detail::SampleLayout layout_;
  const std::shared_ptr<BufferPool> heap_;
  const std::shared_ptr<WriterPort> udp_;
  const std::unique_ptr<History> history_;  ///< null unless durability asks for it
  const std::shared_ptr<DeliveryBook> book_ = std::make_shared<DeliveryBook>();
  Snapshot<Outlets> outlets_;
  CallCount calls_;  ///< of those that read the outlets: publish(), publish_cdr(), loan(), commit()
  std::atomic<std::uint64_t> sequence_{0};
  std::atomic<std::uint64_t> dropped_{0};
  std::atomic<std::uint64_t> exhausted_{0};
  std::atomic<std::uint64_t> too_large_{0};
  std::atomic<std::uint64_t> unavailable_{0};
  std::atomic<std::uint64_t> asserted_{0};
  std::atomic<bool> assertion_told_{false};
  std::atomic<std::uint64_t> deadlines_missed_{0};
  std::atomic<bool> alive_{true};
  EventSink events_;
  NewsSink<PublisherStatus> readers_changed_;

  mutable std::mutex status_mutex_;
  mutable std::condition_variable readers_known_;  ///< that they may be others than before
  std::vector<ReaderStatus> readers_;
  FieldMask encoded_;  ///< at present

  // Of the publisher's thread.
  std::chrono::nanoseconds patience_{0};  ///< for readers, what is left of it in the present call
  const Outlets* counted_ = nullptr;      ///< whose page is open
  SampleHandle spare_;                    ///< from the heap; the next sample's, if nobody else has it by then
  detail::PostponedCopies postponed_;     ///< of the present sample
  std::uint32_t measured_bytes_ = 0;      ///< of a sample with all its fields, and when it was published
  std::int64_t measured_at_ns_ = 0;
  std::uint64_t diverted_sequence_ = 0;  ///< the last one sent by UDP alone, and when it was published
  std::int64_t diverted_stamp_ns_ = 0;
  std::string why_invalid_;

  // Of the agent's thread.
  RateGates gates_;
  std::map<EndpointId, Locator> history_begun_;  ///< readers that are being given the history, and where
  std::vector<Route> late_in_shm_;               ///< to readers that are, or will be, given it there
  std::set<EndpointId> by_udp_;                  ///< readers that are served so
};

}  // namespace sft::core
