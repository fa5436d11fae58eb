// The samples of one writer for one destination, under one mask and limit, that could not be sent at once: a
// queue from the publisher's thread to the sending thread that keeps the newest. A destination that falls
// behind loses samples of its own lanes only.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/seam/delivery.h"
#include "core/sync/lock_order.h"
#include "core/sync/mutex.h"
#include "udp_transport/flow/destination.h"
#include "udp_transport/outgoing/job.h"
#include "udp_transport/outgoing/wake.h"
#include "udp_transport/outgoing/writer_tally.h"
#include "udp_transport/reliable/lane_end.h"
#include "udp_transport/reliable/lane_queue.h"
#include "udp_transport/reliable/unproven_burst.h"

namespace sft::udp {

class Channel;

class Lane {
 public:
  enum class Start : std::uint8_t { open, held };

  /// A held lane keeps what is posted until begin() gave it the history, which has to go first. Meanwhile
  /// more may wait there than `depth`: 256 small samples, or with a channel as much as that may keep
  /// (ResendLimits). In an open lane 4,096 small samples of 1 MiB in all may wait while its receiver is asked
  /// to report for the first time, and for 250 ms after that if some have waited.
  Lane(std::shared_ptr<Destination> to, std::size_t depth, std::shared_ptr<WriterTally> tally,
       Start start = Start::open, std::shared_ptr<Channel> channel = {});

  // Any thread.

  LaneEnd& end() { return end_; }
  Destination& destination() const { return end_.destination(); }
  bool is_late() const { return late_; }
  /// The jobs of the lane go on through this channel; null: they go to the destination.
  Channel* channel() const { return channel_.get(); }
  const std::shared_ptr<Channel>& shared_channel() const { return channel_; }
  /// Samples that were to go this way and did not.
  const std::shared_ptr<core::LossTally>& losses() const { return losses_; }
  /// No reader is there any more: queued jobs are dropped, and none is queued again.
  void close();
  bool closed() const { return closed_.load(std::memory_order_acquire); }

  /// The position of the destination where the last large sample of this lane ended; 0: there was none.
  std::uint64_t behind() const { return behind_.load(std::memory_order_relaxed); }

  // The publisher's thread.

  /// Nothing is queued or being sent by this lane.
  bool idle() const { return !busy_.load(std::memory_order_acquire); }
  /// True if a sample that is sent now overtakes nothing: this lane is idle, and so is each lane of the
  /// writer that may lead to the same receiver, if one of the two is merged.
  bool is_clear() const;

  struct Posted {
    Wake wake = Wake::none;
    std::size_t dropped = 0;  ///< older samples that had to go, since the queue was full
  };
  Posted post(JobHandle job);
  /// One more can be queued and nothing has to go for it.
  bool has_room();
  /// Waits until the job can be queued and nothing has to go for it, as long as `timeout` lasts, which it
  /// uses up.
  void await_room(const Job& job, std::chrono::nanoseconds& timeout);

  /// Notes the first sequence of the lane in a job that is sent without being queued.
  void mark(Job& job);
  /// Samples that are sent from now on must not overtake those that were sent up to that position. Used
  /// by the sending thread, too.
  void stay_behind(std::uint64_t position) { behind_.store(position, std::memory_order_relaxed); }

  // The agent's thread.

  /// Lets a held lane go on, once. The retained samples, however many, go before all that was posted.
  [[nodiscard]] Wake begin(std::vector<JobHandle> history);
  /// Nothing is queued, and the reader has acknowledged what was retained, where it does that: from now on
  /// nothing that is published can push that out.
  bool history_has_departed() const;

  // The sending thread.

  /// The next job, valid until the next call; null if there is none, which makes the lane idle.
  const Job* next();
  /// The job that next() returned.
  const JobHandle& current() const { return current_.job; }
  WriterTally& tally() const { return *tally_; }
  /// The job that next() gave did not leave.
  void lose_current();
  /// The channel keeps the job that next() gave, under that ordinal.
  void passed_on(std::uint64_t ordinal);

 private:
  using Clock = std::chrono::steady_clock;

  void count_lost(const Job& job) const;
  void set_scheduled(bool scheduled) SFT_REQUIRES(mutex_);
  std::optional<Posted> queue_up(JobHandle& job, JobHandle& oldest);
  bool has_room_for(const Job& job) const SFT_REQUIRES(mutex_);
  bool may_pile_up(Clock::time_point now) const SFT_REQUIRES(mutex_);
  void note_report(const Job& job) SFT_REQUIRES(mutex_);

  LaneEnd end_;
  const bool late_;  ///< began as held
  const std::shared_ptr<Channel> channel_;
  const std::shared_ptr<WriterTally> tally_;
  const std::shared_ptr<core::LossTally> losses_ = std::make_shared<core::LossTally>();
  std::atomic<bool> busy_;  ///< scheduled_ or held_, as the publisher sees it
  std::atomic<bool> closed_{false};
  std::atomic<std::uint64_t> behind_{0};
  std::atomic<std::uint64_t> last_retained_{0};  ///< its ordinal in the channel; 0: none was passed on
  LaneQueue::Next current_;                      ///< the present job; used by the sending thread
  bool is_lost_ = false;                         ///< the present job was not sent; used by the sending thread
  core::Mutex mutex_ SFT_ACQUIRED_AFTER(core::lock_order::endpoint)
      SFT_ACQUIRED_BEFORE(core::lock_order::queues);
  core::Condition room_;                                  ///< the queue has become shorter
  bool scheduled_ SFT_GUARDED_BY(mutex_) = false;         ///< the sending thread knows of it
  bool counts_as_merged_ SFT_GUARDED_BY(mutex_) = false;  ///< while it is scheduled
  bool held_ SFT_GUARDED_BY(mutex_);
  LaneQueue queue_ SFT_GUARDED_BY(mutex_);
  UnprovenBurst burst_ SFT_GUARDED_BY(mutex_);
};

}  // namespace sft::udp
