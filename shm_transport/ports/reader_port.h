// A reader: one iceoryx subscriber port for each writer that it is connected to, polled in turn.
//
// What writers left that it was disconnected from is taken first, and is no more than one `depth` of samples
// in all: a publisher that is restarted again and again, while nobody takes, must not use up the daemon's
// chunks and ports. The oldest go, and are counted.
#pragma once

#include <algorithm>
#include <atomic>
#include <memory>
#include <mutex>
#include <vector>

#include "core/seam/transport.h"
#include "shm_transport/host/chunk_slots.h"
#include "shm_transport/host/sample_check.h"
#include "shm_transport/host/session.h"
#include "shm_transport/host/shm_options.h"
#include "shm_transport/host/statistics.h"

namespace sft::shm {

/// What one writer sends to one reader. Outlives the port as long as a sample of it is held anywhere.
class ChunkBorrower final : public core::BufferOwner,
                            public SessionMember,
                            public std::enable_shared_from_this<ChunkBorrower> {
 public:
  static std::shared_ptr<ChunkBorrower> make(std::shared_ptr<Session> session,
                                             iox::popo::SubscriberPortData& port, core::EndpointId writer,
                                             const TypeSupport& type, std::shared_ptr<Statistics> statistics,
                                             std::uint32_t held_limit, const QueueWishes& wishes);
  ~ChunkBorrower() override;

  core::EndpointId writer() const { return writer_; }
  bool open() const noexcept;     ///< neither closed nor lost
  bool drained() const noexcept;  ///< not open, and nothing is left to be taken
  bool connected() noexcept;      ///< one thread at a time
  /// What the writer retains comes first, and nothing has come yet.
  bool awaits_retained() noexcept { return retained_first_ && arrivals() == 0; }
  /// Changes whenever something has arrived.
  std::uint64_t arrivals() noexcept;
  std::uint64_t discarded() const noexcept { return discarded_.load(std::memory_order_relaxed); }
  std::uint64_t held_too_many() const noexcept { return held_too_many_.load(std::memory_order_relaxed); }

  /// The oldest valid sample; malformed ones are counted and skipped. One thread at a time.
  core::SampleHandle take() noexcept;
  /// Something was taken while the writer waited for room. Any thread.
  bool owes_wake() const noexcept { return owes_wake_.load(std::memory_order_relaxed); }
  /// Wakes the writer, if that is so. Any thread, without a lock.
  void wake_writer() noexcept;
  /// No more samples than those that have arrived, which can still be taken.
  void close() noexcept;
  /// Of one that is closed: how many these are, and throwing away the oldest.
  std::uint64_t left() const noexcept;
  void drop_oldest() noexcept;
  /// Of those dropped, the ones before the first that was taken and behind the last: no gap in the sequences
  /// tells of them.
  std::uint64_t lost_unnoticed() const noexcept { return dropped_at_begin_ + dropped_since_; }

  void recycle(core::SampleBuffer& buffer) noexcept override;
  void lose() noexcept override;

 private:
  ChunkBorrower(std::shared_ptr<Session> session, iox::popo::SubscriberPortData& port,
                core::EndpointId writer, const TypeSupport& type, std::shared_ptr<Statistics> statistics,
                std::uint32_t held_limit, const QueueWishes& wishes);
  ChunkSlot* next_chunk() noexcept;
  bool check(ChunkSlot& slot) noexcept;
  void enter(std::uint64_t sequence) noexcept;

  const std::shared_ptr<Session> session_;
  const core::EndpointId writer_;
  const TypeSupport& type_;
  const std::shared_ptr<Statistics> statistics_;
  const bool retained_first_;
  const bool is_awaited_;  ///< the writer waits for room in the queue
  std::atomic<bool> owes_wake_{false};
  std::atomic<std::uint64_t> discarded_{0};
  std::atomic<std::uint64_t> held_too_many_{0};

  /// Of the thread that asks whether it is connected: the writer's port where it last was.
  const iox::popo::PublisherPortData* feeder_ = nullptr;

  // Of the thread that takes (or drops).
  bool overflowed_ = false;            ///< iceoryx has reported it since the last sample
  std::uint64_t last_sequence_ = 0;    ///< 0: none yet
  std::uint64_t unexplained_gap_ = 0;  ///< no overflow was reported so far that could have made it
  std::uint64_t explicable_ = 0;       ///< until so many were popped one may still be
  std::uint64_t dropped_at_begin_ = 0;
  std::uint64_t dropped_since_ = 0;  ///< the last one that was taken

  mutable std::mutex mutex_;  // guards what follows; never held over a system call
  bool open_ = true;          ///< neither closed nor lost
  bool lost_ = false;
  std::uint64_t arrived_ = 0;  ///< when it was closed, and not yet taken
  std::uint64_t popped_ = 0;
  std::uint64_t overflows_ = 0;    ///< that arrivals() came to know of
  bool overflow_is_news_ = false;  ///< to the thread that takes
  bool at_limit_ = false;          ///< as many are held as may be, which was counted
  iox::popo::SubscriberPortData& data_;
  iox::popo::SubscriberPortUser port_;
  ChunkSlots slots_;
};

class ShmReaderPort final : public core::ReaderPort {
 public:
  ShmReaderPort(std::shared_ptr<Session> session, const core::ReaderSpec& spec, const ShmOptions& options,
                std::shared_ptr<Statistics> statistics);
  ~ShmReaderPort() override;

  core::SampleHandle take() noexcept override;
  core::SampleHandle take_of(core::EndpointId writer) noexcept override;
  Result<void> connect(const core::Source& source) override;
  bool connected(core::EndpointId writer) const noexcept override;
  core::HistoryProgress history(core::EndpointId writer) const noexcept override;
  std::uint64_t arrivals(core::EndpointId writer) noexcept override;
  void disconnect(core::EndpointId writer) noexcept override;
  void accept(std::vector<core::Accepted>) override {}  // there is one variant in shared memory: all of it
  std::uint64_t discarded() const noexcept override;
  std::uint64_t held_too_many() const noexcept override;
  std::uint64_t lost_unnoticed() const noexcept override;
  void tell_of_room() noexcept override;

 private:
  using Writers = std::vector<std::shared_ptr<ChunkBorrower>>;
  std::shared_ptr<ChunkBorrower> find(core::EndpointId writer) const noexcept;
  std::uint32_t max_held() const noexcept { return std::clamp(spec_.max_held, 1U, options_.held_limit); }
  std::uint32_t depth() const noexcept { return std::clamp(spec_.depth, 1U, options_.queue_limit); }
  core::SampleHandle take_what_was_left(Writers& drained) noexcept;
  void drop_excess() noexcept;
  Writers forget_drained() noexcept;

  const std::shared_ptr<Session> session_;
  const core::ReaderSpec spec_;
  const ShmOptions options_;
  const std::shared_ptr<Statistics> statistics_;

  mutable std::mutex mutex_;  // guards what follows
  Writers writers_;
  Writers departed_;  ///< disconnected and not yet drained, in that order
  std::size_t next_writer_ = 0;
  // Of writers that it has let go of.
  std::uint64_t discarded_before_ = 0;
  std::uint64_t held_too_many_before_ = 0;
  std::uint64_t lost_unnoticed_ = 0;
};

}  // namespace sft::shm
