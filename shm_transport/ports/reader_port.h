// The reader's end of a topic in shared memory. A reader has one subscriber port of iceoryx for each writer
// that it is connected to, and takes samples from these ports in turn.
//
// Samples that arrived before the session was lost can still be taken.
//
// Samples of a writer from which the reader was disconnected can still be taken, and are taken before the
// samples of other writers. At most `depth` samples and `depth_bytes` of all such writers are kept, because a
// publisher that is restarted again and again while no thread takes samples must not use up the chunks and
// ports of the daemon. The oldest samples are dropped, and are counted.
#pragma once

#include <algorithm>
#include <atomic>
#include <memory>
#include <optional>
#include <vector>

#include "core/seam/transport.h"
#include "core/sync/lock_order.h"
#include "core/sync/mutex.h"
#include "shm_transport/host/queue_places.h"
#include "shm_transport/host/sample_check.h"
#include "shm_transport/host/session.h"
#include "shm_transport/host/shm_options.h"
#include "shm_transport/host/statistics.h"
#include "shm_transport/ports/chunk_queue.h"
#include "shm_transport/ports/loss_account.h"

namespace sft::shm {

/// The connection of a reader to one writer. The object finds the samples in the chunks of its queue, and
/// lends these samples. It outlives the port of the reader for as long as any of the samples is held.
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
  /// True if the queue is neither closed nor lost.
  bool open() const noexcept { return queue_.open(); }
  /// True if the queue is not open, and no sample remains to be taken.
  bool drained() const noexcept { return queue_.drained(); }
  bool connected() noexcept;  ///< must be called by one thread at a time
  /// Returns whether this reader gets the retained samples of the writer first, and no sample has arrived
  /// yet.
  bool awaits_retained() noexcept { return retained_first_ && arrivals() == 0; }
  bool some_wait() const noexcept { return queue_.some_wait(); }
  /// Returns a number that changes whenever a sample has arrived.
  std::uint64_t arrivals() noexcept { return queue_.arrivals(); }
  std::uint64_t discarded() const noexcept { return discarded_.load(std::memory_order_relaxed); }
  std::uint64_t held_too_many() const noexcept { return held_too_many_.load(std::memory_order_relaxed); }

  /// Takes the oldest valid sample. Malformed samples are counted and skipped. Must be called by one thread
  /// at a time.
  core::SampleHandle take() noexcept;
  /// Returns whether a sample was taken while the writer waited for room. Any thread may call this.
  bool owes_wake() const noexcept { return owes_wake_.load(std::memory_order_relaxed); }
  /// Wakes the writer if owes_wake() is true. Any thread may call this, but must hold no lock.
  void wake_writer() noexcept;
  /// Ends the connection. The samples that arrived before this call can still be taken.
  void close() noexcept { queue_.close(); }
  /// Returns the number of samples that remain to be taken once open() is false; 0 until then.
  std::uint64_t left() const noexcept { return queue_.left(); }
  std::uint64_t bytes_left() const noexcept { return queue_.bytes_left(); }
  /// Drops the oldest remaining sample once open() is false. Returns its part of bytes_left(); nothing if no
  /// sample remains, or until then.
  std::optional<std::uint64_t> drop_oldest() noexcept;
  /// Returns the number of missing samples that no gap in the sequence numbers shows.
  std::uint64_t lost_unnoticed() const noexcept { return losses_.lost_unnoticed(); }

  void recycle(core::SampleBuffer& buffer) noexcept override;
  void lose(Loss loss) noexcept override { queue_.lose(loss); }
  bool sends() const noexcept override { return false; }

 private:
  ChunkBorrower(std::shared_ptr<Session> session, iox::popo::SubscriberPortData& port,
                core::EndpointId writer, const TypeSupport& type, std::shared_ptr<Statistics> statistics,
                std::uint32_t held_limit, const QueueWishes& wishes);
  void count_held_too_many() noexcept;
  bool check(ChunkSlot& slot, std::uint64_t popped) noexcept;
  std::uint64_t depth() const noexcept { return QueuePlaces(queue_.port(), is_deepest_).depth(); }

  const std::shared_ptr<Session> session_;
  const core::EndpointId writer_;
  const TypeSupport& type_;
  const std::shared_ptr<Statistics> statistics_;
  const bool retained_first_;
  const bool is_awaited_;  ///< true if the writer waits for room in the queue
  const bool is_deepest_;  ///< true if the queue has no spare place
  std::atomic<bool> owes_wake_{false};
  std::atomic<std::uint64_t> discarded_{0};
  std::atomic<std::uint64_t> held_too_many_{0};

  /// The port of the writer that connected() found last. Used only by the thread that calls connected().
  const iox::popo::PublisherPortData* feeder_ = nullptr;

  LossAccount losses_;  ///< used only by the thread that takes or drops samples
  ChunkQueue queue_;
};

class ShmReaderPort final : public core::BorrowingReader {
 public:
  ShmReaderPort(std::shared_ptr<Session> session, const core::ReaderSpec& spec, const ShmOptions& options,
                std::shared_ptr<Statistics> statistics);
  ~ShmReaderPort() override;

  core::SampleHandle take() noexcept override;
  core::SampleHandle take_of(core::EndpointId writer) noexcept override;
  bool some_wait() const noexcept override;
  Result<void> connect(const core::Source& source) override;
  bool connected(core::EndpointId writer) const noexcept override;
  core::HistoryProgress history(core::EndpointId writer) const noexcept override;
  std::uint64_t arrivals(core::EndpointId writer) noexcept override;
  void disconnect(core::EndpointId writer) noexcept override;
  Counters counters() const noexcept override;
  std::uint64_t held_too_many() const noexcept override;
  void notify_room() noexcept override;

 private:
  using Writers = std::vector<std::shared_ptr<ChunkBorrower>>;
  std::shared_ptr<ChunkBorrower> find(core::EndpointId writer) const noexcept;
  std::uint32_t max_held() const noexcept { return std::clamp(spec_.max_held, 1U, options_.held_limit); }
  std::uint32_t depth() const noexcept { return std::clamp(spec_.depth, 1U, options_.queue_limit); }
  core::SampleHandle take_what_was_left(Writers& drained) noexcept SFT_REQUIRES(mutex_);
  void drop_excess() noexcept SFT_REQUIRES(mutex_);
  Writers forget_drained() noexcept SFT_REQUIRES(mutex_);

  const std::shared_ptr<Session> session_;
  const core::ReaderSpec spec_;
  const ShmOptions options_;
  const std::shared_ptr<Statistics> statistics_;

  mutable core::Mutex mutex_ SFT_ACQUIRED_AFTER(core::lock_order::endpoint)
      SFT_ACQUIRED_BEFORE(core::lock_order::queues);
  Writers writers_ SFT_GUARDED_BY(mutex_);
  /// The writers that were disconnected and are not yet drained, in the order of disconnection.
  Writers departed_ SFT_GUARDED_BY(mutex_);
  std::size_t next_writer_ SFT_GUARDED_BY(mutex_) = 0;
  // The sums of the counters of writers that were drained and removed.
  std::uint64_t discarded_before_ SFT_GUARDED_BY(mutex_) = 0;
  std::uint64_t held_too_many_before_ SFT_GUARDED_BY(mutex_) = 0;
  std::uint64_t lost_unnoticed_ SFT_GUARDED_BY(mutex_) = 0;
};

}  // namespace sft::shm
