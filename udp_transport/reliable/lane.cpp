#include "udp_transport/reliable/lane.h"

#include <algorithm>
#include <utility>

#include "udp_transport/reliable/channel.h"

namespace sft::udp {

namespace {
// The maximum numbers of jobs that may wait in a lane without a channel: in a late lane, and in any other
// lane until the first report of its receiver. The report takes a round trip, during which a program may
// publish a burst of small samples.
constexpr std::size_t late_jobs_max = 256, unproven_jobs_max = 4096;
constexpr std::size_t late_bytes_max = std::size_t{1} << 20;
// With a channel, as many jobs may wait as the channel may keep.
constexpr ResendLimits channel_limits;

LaneQueue::Limits beyond_depth(bool late, bool has_channel) {
  if (has_channel) return {.jobs = channel_limits.samples, .bytes = channel_limits.bytes};
  return {.jobs = late ? late_jobs_max : unproven_jobs_max, .bytes = late_bytes_max};
}
}  // namespace

Lane::Lane(std::shared_ptr<Destination> to, std::size_t depth, std::shared_ptr<WriterTally> tally,
           Start start, std::shared_ptr<Channel> channel)
    : end_(std::move(to)),
      late_(start == Start::held),
      channel_(std::move(channel)),
      tally_(std::move(tally)),
      busy_(start == Start::held),
      held_(start == Start::held),
      queue_(depth, beyond_depth(late_, channel_ != nullptr)) {}

Lane::Posted Lane::post(JobHandle job) {
  std::optional<Posted> posted;
  for (std::size_t dropped = 0; !posted;) {
    JobHandle oldest;
    posted = queue_up(job, oldest);
    if (oldest) count_lost(*oldest);
    if (oldest) dropped += oldest->samples();
    end_.departed(oldest, true);
    if (posted) posted->dropped = dropped;
  }
  end_.departed(job, true);
  return *posted;
}

/// Queues the job, and drops the oldest one if the queue is full. A job that was not queued stays in `job`.
/// The dropped job is returned in `oldest`, so that listeners are called without the lock. Returns nothing
/// if one more job has to be dropped first.
std::optional<Lane::Posted> Lane::queue_up(JobHandle& job, JobHandle& oldest) {
  const core::Lock lock(mutex_);
  if (closed()) return Posted{};
  note_report(*job);
  if (!has_room_for(*job)) {
    oldest = queue_.pop_oldest();
    if (!has_room_for(*job)) return {};
  }
  if (late_ && channel_ != nullptr) job->keep();
  queue_.post(std::move(job));
  busy_.store(true, std::memory_order_relaxed);
  const bool was_idle = !held_ && !scheduled_;
  if (was_idle) set_scheduled(true);
  return Posted{.wake = was_idle ? Wake::schedule : Wake::none};
}

/// Notes whether the sending thread has the lane in its list. It removes the lane when next() finds no job.
void Lane::set_scheduled(bool scheduled) {
  scheduled_ = scheduled;
  const auto note = [&](std::atomic<std::uint32_t>& busy) {
    scheduled ? busy.fetch_add(1, std::memory_order_relaxed) : busy.fetch_sub(1, std::memory_order_release);
  };
  note(tally_->busy_lanes);
  if (scheduled) counts_as_merged_ = end_.is_merged();
  if (counts_as_merged_) note(tally_->busy_merged_lanes);
}

bool Lane::has_room() {
  const core::Lock lock(mutex_);
  return queue_.has_room() && !closed();
}

bool Lane::is_clear() const {
  const std::atomic<std::uint32_t>& others =
      end_.is_merged() ? tally_->busy_lanes : tally_->busy_merged_lanes;
  return idle() && others.load(std::memory_order_acquire) == 0;
}

bool Lane::has_room_for(const Job& job) const {
  if (queue_.has_room()) return true;
  if (!late_ && !(job.is_small() && may_pile_up(Clock::now()))) return false;
  return queue_.has_room_beyond_depth(job) &&
         (channel_ == nullptr || !channel_->must_give_up_some_of(queue_.bytes_with(job)));
}

/// Returns true if the receiver has not reported yet and is not mute, and for a short time after its first
/// report.
bool Lane::may_pile_up(Clock::time_point now) const {
  return burst_.awaits_report() ? !destination().window().is_mute(now) : burst_.is_just_reported(now);
}

void Lane::note_report(const Job& job) {
  if (!destination().window().answers()) {
    burst_.await_report(job.is_small());
  } else if (burst_.awaits_report()) {
    burst_.reported(Clock::now());
  }
}

void Lane::await_room(const Job& job, std::chrono::nanoseconds& timeout) {
  core::Lock lock(mutex_);
  note_report(job);
  if (closed() || has_room_for(job)) return;
  const Clock::time_point begin = Clock::now();
  bool has_time = true;
  while (has_time && !closed() && !has_room_for(job)) has_time = room_.wait_until(lock, begin + timeout);
  timeout = std::max<std::chrono::nanoseconds>(timeout - (Clock::now() - begin), {});
}

void Lane::lose_current() {
  tally_->dropped.fetch_add(current_.job->samples(), std::memory_order_relaxed);
  is_lost_ = true;
  if (!current_.is_retained) count_lost(*current_.job);
}

void Lane::count_lost(const Job& job) const {
  losses_->lost(job.first.total, job.whole_bytes, job.samples());
}

void Lane::mark(Job& job) {
  const core::Lock lock(mutex_);
  queue_.mark(job);
}

Wake Lane::begin(std::vector<JobHandle> history) {
  const core::Lock lock(mutex_);
  if (!std::exchange(held_, false) || closed()) return Wake::none;
  queue_.put_first(std::move(history));
  if (!queue_.empty()) set_scheduled(true);
  busy_.store(scheduled_, std::memory_order_release);
  return scheduled_ ? Wake::schedule : Wake::none;
}

bool Lane::history_has_departed() const {
  if (!idle()) return false;
  const std::uint64_t last = last_retained_.load(std::memory_order_acquire);
  return last == 0 || channel_ == nullptr || channel_->closed() || !channel_->keeps(last);
}

void Lane::passed_on(std::uint64_t ordinal) {
  if (current_.is_retained) last_retained_.store(ordinal, std::memory_order_release);
}

const Job* Lane::next() {
  end_.departed(current_.job, std::exchange(is_lost_, false));
  current_ = {};
  const core::Lock lock(mutex_);
  current_ = queue_.take();
  if (!current_.job) {
    if (scheduled_) set_scheduled(false);
    busy_.store(false, std::memory_order_release);
    return nullptr;
  }
  if (!current_.is_retained) room_.notify_one();
  return &*current_.job;
}

void Lane::close() {
  LaneQueue::Contents dropped;  // destroyed without the lock
  {
    const core::Lock lock(mutex_);
    closed_.store(true, std::memory_order_release);
    room_.notify_one();
    dropped = queue_.clear();
  }
  for (std::uint64_t n = dropped.posted.begin(); n != dropped.posted.end(); ++n)
    end_.departed(dropped.posted[n], true);
}

}  // namespace sft::udp
