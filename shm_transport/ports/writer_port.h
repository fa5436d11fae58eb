// A writer: one iceoryx publisher port that only readers of this writer subscribe to.
//
// Chunks. iceoryx itself keeps account of 8 chunks on loan, and takes one that was sent back for the next
// loan as soon as readers let go. But whoever keeps a handle (the history, a send to another host under way)
// still reads it. So each chunk, from the loan until its last handle is gone, is in the list of held chunks
// of a subscriber port that belongs to this writer alone and is never subscribed: there the daemon finds it,
// and frees it, when this process is killed. (Subscribing that port would do too, but costs a push, a pop and
// a release for every sample.)
//
// A chunk that is just being taken, delivered or given back when the process is killed has references that
// nobody knows of: see chunk_hand.h.
//
// Late readers get what is retained before all else (audience.h). A writer with `max_blocking` waits for room
// in the queues of the reliable readers that it serves (queue_room.h); all others lose their oldest sample.
#pragma once

#include <chrono>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <vector>

#include "core/seam/transport.h"
#include "core/sync/snapshot.h"
#include "shm_transport/host/chunk_pools.h"
#include "shm_transport/host/chunk_slots.h"
#include "shm_transport/host/session.h"
#include "shm_transport/host/statistics.h"
#include "shm_transport/ports/audience.h"
#include "shm_transport/wake/doorbells.h"

namespace sft::shm {

/// The memory of one writer. Outlives the port as long as a sample of it is held anywhere. Once its session
/// is lost and all samples are back it lets go of that memory: a publisher that publishes nothing may keep
/// its port for long.
class ChunkLender final : public core::BufferOwner,
                          public SessionMember,
                          public std::enable_shared_from_this<ChunkLender> {
 public:
  static std::shared_ptr<ChunkLender> make(std::shared_ptr<Session> session,
                                           iox::popo::PublisherPortData& publisher,
                                           iox::popo::SubscriberPortData& keeper,
                                           const core::WriterSpec& spec, std::uint32_t held_limit);
  ~ChunkLender() override;

  /// A chunk with a fresh header; empty if there is none, or none so large. Any thread.
  core::SampleHandle lend(std::size_t bytes) noexcept;
  /// What the largest chunk holds. Any thread.
  std::size_t largest_bytes() const noexcept { return largest_bytes_; }

  enum class Commit { done, displaced, busy, full, lost };
  /// Hands a lent sample to all subscribed readers, or to none. `busy`: the daemon holds the port's lock,
  /// which it does for microseconds unless it was stopped or killed there. `full`: a reader that is waited
  /// for has no room, and `may_wait`; without that it loses its oldest sample, which is `displaced`.
  Commit commit(ChunkSlot& slot, bool to_readers, bool may_wait) noexcept;
  /// After `full`: sleeps until that reader has room, at most until then, and never long. It is to be tried
  /// again then.
  void await_room(Clock::time_point until) noexcept;

  /// Whether the sample was lent here and not yet committed: only such ones can be.
  bool has_lent(const core::SampleBuffer& sample) const noexcept;
  /// Whether it was lent here at all.
  bool owns(const core::SampleBuffer& sample) const noexcept { return sample.owner.get() == this; }

  // Readers that wait for what is retained (audience.h). None of it waits for the daemon: then it is as if
  // nobody did.
  std::optional<std::uint64_t> held_back(core::EndpointId reader) noexcept;
  bool begin(core::EndpointId reader, const std::vector<core::SampleHandle>& retained,
             std::uint64_t held_back) noexcept;
  void owe_nothing(std::set<core::EndpointId> readers) noexcept;
  /// commit() waits for these, of those that wish it.
  void wait_for(std::set<core::EndpointId> readers) noexcept;

  void recycle(core::SampleBuffer& buffer) noexcept override;
  void lose() noexcept override;

 private:
  ChunkLender(std::shared_ptr<Session> session, iox::popo::PublisherPortData& publisher,
              iox::popo::SubscriberPortData& keeper, const core::WriterSpec& spec, std::uint32_t held_limit);
  iox::mepoo::ChunkHeader* allocate(std::size_t bytes) noexcept;
  void hold(ChunkSlot& slot, iox::mepoo::ChunkHeader& chunk) noexcept;
  void deliver(ChunkSlot& slot) noexcept;
  struct FullQueue {
    Audience::Listener listener;
    std::shared_ptr<Session> session;  ///< keeps it mapped
  };
  std::optional<FullQueue> full_queue() noexcept;
  std::shared_ptr<Session> let_go() noexcept;

  const FieldMask full_mask_;
  const std::size_t largest_bytes_;
  const bool retains_;
  const bool waits_;  ///< for readers

  mutable std::mutex mutex_;  // guards what follows; never held over a system call
  bool lost_ = false;
  std::shared_ptr<Session> session_;  ///< keeps mapped what the references below are to; null: do not touch
  iox::popo::PublisherPortData& publisher_;
  iox::popo::PublisherPortUser port_;
  iox::popo::SubscriberPortData& keeper_;
  ChunkPools& pools_;
  ChunkSlots slots_;
  Audience audience_;
};

class ShmWriterPort final : public core::WriterPort {
 public:
  ShmWriterPort(std::shared_ptr<ChunkLender> chunks, std::shared_ptr<DoorbellPages> pages,
                std::shared_ptr<Statistics> statistics, std::chrono::nanoseconds max_blocking = {},
                core::TrustedAccounts reader_accounts = {})
      : chunks_(std::move(chunks)),
        pages_(std::move(pages)),
        statistics_(std::move(statistics)),
        max_blocking_(max_blocking),
        reader_accounts_(std::move(reader_accounts)) {}

  core::SampleHandle loan(std::size_t bytes) noexcept override;
  std::size_t largest_loan_bytes() const noexcept override { return chunks_->largest_bytes(); }
  core::SendStatus send(const core::SampleHandle& sample) noexcept override;
  bool can_send(const core::SampleBuffer& sample) const noexcept override {
    return chunks_->has_lent(sample);
  }
  std::string why_unreachable(const core::Route& to) override;
  void set_routes(std::vector<core::Route> routes) override;
  bool holds(const core::SampleBuffer& sample) const noexcept override { return chunks_->owns(sample); }
  std::optional<std::uint64_t> held_back(core::EndpointId reader) noexcept override {
    return chunks_->held_back(reader);
  }
  bool begin_with(const core::Route& to, const std::vector<core::SampleHandle>& retained,
                  std::uint64_t held_back) override;
  void be_patient(std::chrono::nanoseconds at_most) noexcept override { patience_max_ = at_most; }
  std::chrono::nanoseconds patience_left() const noexcept override { return patience_; }
  std::uint64_t bytes_sent() const noexcept override { return 0; }

 private:
  core::SendStatus drop() noexcept;
  ChunkLender::Commit commit(ChunkSlot& slot, bool to_readers, bool may_wait) noexcept;
  ChunkLender::Commit commit_once_there_is_room(ChunkSlot& slot) noexcept;

  const std::shared_ptr<ChunkLender> chunks_;
  const std::shared_ptr<DoorbellPages> pages_;
  const std::shared_ptr<Statistics> statistics_;
  const std::chrono::nanoseconds max_blocking_;
  const core::TrustedAccounts reader_accounts_;               ///< whose doorbells it rings
  std::vector<std::shared_ptr<core::DoorbellPage>> reached_;  ///< stay open until the next routes are set

  // Of the publisher's thread.
  std::chrono::nanoseconds patience_max_ = std::chrono::nanoseconds::max();
  std::chrono::nanoseconds patience_{0};  ///< of the present sample

  core::Snapshot<Doorbells> doorbells_;  ///< null without routes
};

}  // namespace sft::shm
