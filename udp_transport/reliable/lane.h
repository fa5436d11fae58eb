// The samples of one writer for one destination, under one mask and rate, that could not be sent at once. A
// lane is a queue from the publisher's thread to the sending thread that keeps the newest samples. A
// destination that is too slow loses only samples of its own lanes.
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

  /// A held lane keeps posted jobs until begin() adds the history, which has to be sent first. Meanwhile
  /// more than `depth` jobs may wait there: 256 small samples, or with a channel as many as the channel may
  /// keep (ResendLimits). In an open lane 4,096 small samples of 1 MiB in all may wait while its receiver
  /// is asked for its first report, and for 250 ms after that report if some have waited.
  Lane(std::shared_ptr<Destination> to, std::size_t depth, std::shared_ptr<WriterTally> tally,
       Start start = Start::open, std::shared_ptr<Channel> channel = {});

  // Any thread may call the following functions.

  LaneEnd& end() { return end_; }
  Destination& destination() const { return end_.destination(); }
  bool is_late() const { return late_; }
  /// Returns the channel that sends the jobs of the lane; null: the jobs go to the destination directly.
  Channel* channel() const { return channel_.get(); }
  const std::shared_ptr<Channel>& shared_channel() const { return channel_; }
  /// Returns the counts of samples that were posted to this lane and not sent.
  const std::shared_ptr<core::LossTally>& losses() const { return losses_; }
  /// Drops queued jobs and queues no further ones, because no reader is left.
  void close();
  bool closed() const { return closed_.load(std::memory_order_acquire); }

  /// Returns the position in the destination's stream of bytes where the last large sample of this lane
  /// ended; 0: there was none.
  std::uint64_t behind() const { return behind_.load(std::memory_order_relaxed); }

  // The following functions are for the publisher's thread.

  /// Returns true if this lane queues and sends nothing.
  bool idle() const { return !busy_.load(std::memory_order_acquire); }
  /// Returns true if a sample that is sent now overtakes no other sample. This lane must be idle. If this
  /// lane or another lane of the writer is merged and both may lead to the same receiver, the other lane
  /// must be idle, too.
  bool is_clear() const;

  struct Posted {
    Wake wake = Wake::none;
    std::size_t dropped = 0;  ///< older samples that were given up because the queue was full
  };
  Posted post(JobHandle job);
  /// Returns true if one more job can be queued without giving up an older one.
  bool has_room();
  /// Waits until the job can be queued without giving up an older one, for at most `timeout`. Subtracts the
  /// time of waiting from `timeout`.
  void await_room(const Job& job, std::chrono::nanoseconds& timeout);

  /// Writes the first sequence of the lane into a job that is sent without being queued.
  void mark(Job& job);
  /// Ensures that samples that are sent from now on do not overtake those that were sent up to that
  /// position. Called by the sending thread, too.
  void stay_behind(std::uint64_t position) { behind_.store(position, std::memory_order_relaxed); }

  // The following functions are for the agent's thread.

  /// Starts a held lane. Called once. All retained samples are sent before the posted jobs.
  [[nodiscard]] Wake begin(std::vector<JobHandle> history);
  /// Returns true if nothing is queued, and the reader has acknowledged the retained samples (if the reader
  /// acknowledges samples at all). From then on no new sample can displace them.
  bool history_has_departed() const;

  // The following functions are for the sending thread.

  /// Returns the next job, valid until the next call. Returns null if there is none; the lane is idle then.
  const Job* next();
  /// Returns the job that the last call of next() returned.
  const JobHandle& current() const { return current_.job; }
  WriterTally& tally() const { return *tally_; }
  /// Notes that the job that next() returned was not sent.
  void lose_current();
  /// Notes that the job that next() returned is now kept by the channel, under that ordinal.
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
  const bool late_;  ///< true if the lane was a held one at first
  const std::shared_ptr<Channel> channel_;
  const std::shared_ptr<WriterTally> tally_;
  const std::shared_ptr<core::LossTally> losses_ = std::make_shared<core::LossTally>();
  std::atomic<bool> busy_;  ///< true if `scheduled_` or `held_` is true; read by the publisher's thread
  std::atomic<bool> closed_{false};
  std::atomic<std::uint64_t> behind_{0};
  /// Ordinal of the last retained sample in the channel; 0: there is none in the channel yet.
  std::atomic<std::uint64_t> last_retained_{0};
  LaneQueue::Next current_;  ///< the present job; used by the sending thread
  bool is_lost_ = false;     ///< true if the present job was not sent; used by the sending thread
  core::Mutex mutex_ SFT_ACQUIRED_AFTER(core::lock_order::endpoint)
      SFT_ACQUIRED_BEFORE(core::lock_order::queues);
  core::Condition room_;                           ///< notified when the queue has become shorter
  bool scheduled_ SFT_GUARDED_BY(mutex_) = false;  ///< true if the sending thread knows the lane
  /// Valid while the lane is scheduled: the tally counts it in `busy_merged_lanes`.
  bool counts_as_merged_ SFT_GUARDED_BY(mutex_) = false;
  bool held_ SFT_GUARDED_BY(mutex_);
  LaneQueue queue_ SFT_GUARDED_BY(mutex_);
  UnprovenBurst burst_ SFT_GUARDED_BY(mutex_);
};

}  // namespace sft::udp
