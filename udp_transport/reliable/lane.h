// The samples of one writer for one destination, with one mask and maximum rate, that could not be sent at
// once. A lane is a queue from the publisher's thread to the sending thread. A full lane drops its oldest
// samples, so a destination that is too slow loses only samples of its own lanes.
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
  /// more than `depth` jobs may wait there: up to 256 small samples, or with a channel as many as the
  /// channel may keep (ResendLimits). An open lane may have more, up to 4,096 small samples of 1 MiB in all,
  /// until the first report of its receiver. If some have waited then, the same holds for 250 ms after that
  /// report.
  Lane(std::shared_ptr<Destination> to, std::size_t depth, std::shared_ptr<WriterTally> tally,
       Start start = Start::open, std::shared_ptr<Channel> channel = {});

  // Any thread may call the following functions.

  LaneEnd& end() { return end_; }
  Destination& destination() const { return end_.destination(); }
  bool is_late() const { return late_; }
  /// Returns the channel that sends the jobs of the lane; null: the jobs are sent by best effort, without a
  /// channel.
  Channel* channel() const { return channel_.get(); }
  const std::shared_ptr<Channel>& shared_channel() const { return channel_; }
  /// Returns the counters of samples that were posted to this lane and not sent.
  const std::shared_ptr<core::LossTally>& losses() const { return losses_; }
  /// Drops the queued jobs and accepts no further ones. Called if no reader of the lane is left.
  void close();
  bool closed() const { return closed_.load(std::memory_order_acquire); }

  /// Returns the position in the destination's stream of bytes at which the last large sample of this lane
  /// ended; 0 if the lane has sent no large sample.
  std::uint64_t behind() const { return behind_.load(std::memory_order_relaxed); }

  // The following functions are for the publisher's thread.

  /// Returns true if no job of this lane is queued or being sent.
  bool idle() const { return !busy_.load(std::memory_order_acquire); }
  /// Returns true if a sample that is sent now overtakes no other sample. For that, this lane must be idle.
  /// If another lane of the writer may lead to the same receiver, and one of the two lanes is merged
  /// (LaneEnd::is_merged()), the other lane must be idle, too.
  bool is_clear() const;

  struct Posted {
    Wake wake = Wake::none;
    std::size_t dropped = 0;  ///< number of older samples that were dropped because the queue was full
  };
  Posted post(JobHandle job);
  /// Returns true if one more job can be queued without dropping an older one.
  bool has_room();
  /// Waits until the job can be queued without dropping an older one, for at most `timeout`. Subtracts the
  /// time of waiting from `timeout`.
  void await_room(const Job& job, std::chrono::nanoseconds& timeout);

  /// Writes the sequence of the lane's first sample into a job that is sent without being queued.
  void mark(Job& job);
  /// Ensures that samples of this lane that are sent from now on do not overtake data that was sent up to
  /// that position. Called by the sending thread, too.
  void stay_behind(std::uint64_t position) { behind_.store(position, std::memory_order_relaxed); }

  // The following functions are for the agent's thread.

  /// Starts a held lane. Must be called only once. All retained samples are sent before the posted jobs.
  [[nodiscard]] Wake begin(std::vector<JobHandle> history);
  /// Returns true if no job is queued, and the reader has acknowledged the retained samples (if the reader
  /// is reliable). From then on, no new sample can displace the retained samples.
  bool history_has_departed() const;

  // The following functions are for the sending thread.

  /// Returns the next job, valid until the next call. Returns null if no job is queued. Then the lane is
  /// idle.
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
  const bool late_;  ///< true if the lane was made as a held lane
  const std::shared_ptr<Channel> channel_;
  const std::shared_ptr<WriterTally> tally_;
  const std::shared_ptr<core::LossTally> losses_ = std::make_shared<core::LossTally>();
  std::atomic<bool> busy_;  ///< true if `scheduled_` or `held_` is true; read by the publisher's thread
  std::atomic<bool> closed_{false};
  std::atomic<std::uint64_t> behind_{0};
  /// Ordinal of the last retained sample in the channel; 0: there is none in the channel yet.
  std::atomic<std::uint64_t> last_retained_{0};
  LaneQueue::Next current_;  ///< the job that next() returned; used by the sending thread
  bool is_lost_ = false;     ///< true if that job was not sent; used by the sending thread
  core::Mutex mutex_ SFT_ACQUIRED_AFTER(core::lock_order::endpoint)
      SFT_ACQUIRED_BEFORE(core::lock_order::queues);
  core::Condition room_;                           ///< notified when the queue has become shorter
  bool scheduled_ SFT_GUARDED_BY(mutex_) = false;  ///< true if the sending thread has the lane in its list
  /// True if the tally counts the lane in `busy_merged_lanes`. Valid only while `scheduled_` is true.
  bool counts_as_merged_ SFT_GUARDED_BY(mutex_) = false;
  bool held_ SFT_GUARDED_BY(mutex_);
  LaneQueue queue_ SFT_GUARDED_BY(mutex_);
  UnprovenBurst burst_ SFT_GUARDED_BY(mutex_);
};

}  // namespace sft::udp
