// The writer's end of a topic in shared memory. A writer has one publisher port of iceoryx, to which only
// readers of this writer subscribe.
//
// Chunks: iceoryx itself keeps account of at most 8 chunks on loan. As soon as all readers have released a
// sent chunk, iceoryx uses it for the next loan. But other parts of this process may have a handle to the
// chunk and still read it: the history, or a transmission to another host. So each chunk is in a list of
// held chunks from the loan until its last handle is gone. The list is that of a subscriber port that
// belongs to this writer alone and is never subscribed (the keeper). If this process is killed, the daemon
// finds the chunks there and frees them. (A subscribed keeper would work as well, but costs a push, a pop
// and a release for each sample.)
//
// If the process is killed while it takes, delivers or gives back a chunk, that chunk has references that
// are in no list (chunk_hand.h).
//
// Late readers get the retained samples before all others (attached_queues.h). A writer with `max_blocking`
// waits for room in the queues of the reliable readers that it serves (queue_room.h). All other readers
// lose their oldest sample when their queue is full.
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <set>
#include <vector>

#include "core/seam/transport.h"
#include "core/sync/lock_order.h"
#include "core/sync/mutex.h"
#include "core/sync/published.h"
#include "shm_transport/host/chunk_pools.h"
#include "shm_transport/host/chunk_slots.h"
#include "shm_transport/host/session.h"
#include "shm_transport/host/statistics.h"
#include "shm_transport/ports/attached_queues.h"
#include "shm_transport/wake/doorbell_pages.h"

namespace sft::shm {

/// The object outlives its last user for as long as any of its samples is held. After the session is lost and
/// all samples were given back, the object releases the session's memory at once, because a publisher that
/// publishes nothing may keep its port for long.
class ShmWriterPort final : public core::LendingWriter,
                            public core::BufferOwner,
                            public SessionMember,
                            public std::enable_shared_from_this<ShmWriterPort> {
 public:
  static std::shared_ptr<ShmWriterPort> make(std::shared_ptr<Session> session,
                                             iox::popo::PublisherPortData& publisher,
                                             iox::popo::SubscriberPortData& keeper,
                                             const core::WriterSpec& spec, std::uint32_t held_limit,
                                             std::shared_ptr<DoorbellPages> pages,
                                             std::shared_ptr<Statistics> statistics);
  ~ShmWriterPort() override;

  /// Any thread may call this.
  core::SampleHandle loan(std::size_t bytes) noexcept override;
  std::size_t largest_loan_bytes() const noexcept override { return largest_bytes_; }
  core::SendStatus send(const core::SampleHandle& sample) noexcept override;
  bool can_send(const core::SampleBuffer& sample) const noexcept override;
  std::string why_unreachable(const core::Route& to) override;
  void set_routes(std::vector<core::Route> routes) override;
  bool owns(const core::SampleBuffer& sample) const noexcept override { return sample.owner.get() == this; }
  // If the daemon holds the lock of the port, these two functions do not wait for it. The result is then the
  // same as if no reader waited.
  std::optional<std::uint64_t> held_back(core::EndpointId reader) noexcept override;
  bool begin_with(const core::Route& to, const std::vector<core::SampleHandle>& retained,
                  std::uint64_t held_back) override;
  void set_timeout(std::chrono::nanoseconds at_most) noexcept override { timeout_max_ = at_most; }
  std::chrono::nanoseconds time_left() const noexcept override { return timeout_; }

  void recycle(core::SampleBuffer& buffer) noexcept override;
  void lose(Loss loss) noexcept override;
  bool sends() const noexcept override { return true; }

 private:
  ShmWriterPort(std::shared_ptr<Session> session, iox::popo::PublisherPortData& publisher,
                iox::popo::SubscriberPortData& keeper, const core::WriterSpec& spec, std::uint32_t held_limit,
                std::shared_ptr<DoorbellPages> pages, std::shared_ptr<Statistics> statistics);
  core::SampleHandle lend(std::size_t bytes) noexcept;
  iox::mepoo::ChunkHeader* allocate(std::size_t bytes) noexcept SFT_REQUIRES(mutex_);
  void hold(ChunkSlot& slot, iox::mepoo::ChunkHeader& chunk) noexcept SFT_REQUIRES(mutex_);

  enum class Commit : std::uint8_t {
    done,
    displaced,  ///< `may_wait` is false, and a reader for which the writer waits has lost its oldest sample
    busy,       ///< the daemon holds the lock of the port
    full,       ///< `may_wait` is true, and the queue of a reader for which the writer waits has no room
    lost,
  };
  Commit commit_at_once(ChunkSlot& slot, bool to_readers, bool may_wait) noexcept;
  Commit commit(ChunkSlot& slot, bool to_readers, bool may_wait) noexcept;
  Commit commit_once_there_is_room(ChunkSlot& slot) noexcept;
  void deliver(ChunkSlot& slot) noexcept SFT_REQUIRES(mutex_);
  struct FullQueue {
    QueuePlaces places;
    /// Maximum number of samples that may wait together with the next sample.
    std::uint64_t beside = 0;
    std::shared_ptr<Session> session;  ///< keeps the memory of the queue mapped
  };
  std::optional<FullQueue> full_queue(std::uint64_t bytes) noexcept;
  void await_room(const ChunkSlot& slot, Clock::time_point until) noexcept;
  bool begin(core::EndpointId reader, const std::vector<core::SampleHandle>& retained,
             std::uint64_t held_back) noexcept;
  core::SendStatus drop() noexcept;
  void ring_for_sample() noexcept;
  std::shared_ptr<Session> let_go() noexcept SFT_REQUIRES(mutex_);

  const std::size_t largest_bytes_;
  const bool retains_;
  const std::chrono::nanoseconds max_blocking_;  ///< zero if the writer does not wait for reliable readers
  const std::shared_ptr<DoorbellPages> pages_;
  const std::shared_ptr<Statistics> statistics_;
  /// The accounts whose doorbells this writer rings.
  const core::TrustedAccounts reader_accounts_;
  /// Pages of doorbells that are kept open until set_routes() is called.
  std::vector<std::shared_ptr<core::DoorbellPage>> reached_;
  std::vector<core::Route> routes_;       ///< the routes in force
  core::Published<Doorbells> doorbells_;  ///< the doorbells of the routes; null if there are no routes

  // The next two members are used by the thread of the publisher.
  std::chrono::nanoseconds timeout_max_ = std::chrono::nanoseconds::max();
  std::chrono::nanoseconds timeout_{0};  ///< the remaining time for which the present sample may wait

  mutable core::Mutex mutex_ SFT_ACQUIRED_AFTER(core::lock_order::jobs);  // never held over a system call
  /// True if the session is lost, and iceoryx must not be used any more.
  bool lost_ SFT_GUARDED_BY(mutex_) = false;
  /// Keeps the memory of the ports mapped; null: the ports must not be used.
  std::shared_ptr<Session> session_ SFT_GUARDED_BY(mutex_);
  iox::popo::PublisherPortData& publisher_ SFT_GUARDED_BY(mutex_);
  iox::popo::PublisherPortUser port_ SFT_GUARDED_BY(mutex_);
  iox::popo::SubscriberPortData& keeper_ SFT_GUARDED_BY(mutex_);
  ChunkPools& pools_ SFT_GUARDED_BY(mutex_);
  ChunkSlots slots_ SFT_GUARDED_BY(mutex_);
  AttachedQueues attached_ SFT_GUARDED_BY(mutex_);
};

}  // namespace sft::shm
