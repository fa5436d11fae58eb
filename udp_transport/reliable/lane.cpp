#include "udp_transport/reliable/lane.h"

#include <algorithm>
#include <utility>

#include "udp_transport/reliable/channel.h"

namespace sft::udp {

namespace {
// Jobs that may wait without a channel: in a late lane, or in another lane for the first report of its
// receiver. That is a round trip, in which a program may publish a burst of small samples.
constexpr std::size_t late_jobs_max = 256, unproven_jobs_max = 4096;
constexpr std::size_t late_bytes_max = std::size_t{1} << 20;
// The same number may wait for so long after that report: jobs that have piled up are sent before any is
// dropped for others.
constexpr std::chrono::milliseconds pile_lasts{250};
// With a channel, as much may wait as the channel may keep.
constexpr ResendLimits channel_limits;

std::size_t bytes_held(const Job& job) { return job.held_bytes_in_all(); }
}  // namespace

Lane::Lane(std::shared_ptr<Destination> to, std::size_t depth, std::shared_ptr<WriterTally> tally,
           Start start, std::shared_ptr<Channel> channel)
    : to_(std::move(to)),
      depth_(std::max<std::size_t>(depth, 1)),
      late_(start == Start::held),
      channel_(std::move(channel)),
      tally_(std::move(tally)),
      busy_(start == Start::held),
      held_(start == Start::held) {
  queue_.reserve(depth_);
}

Lane::Posted Lane::post(JobHandle job) {
  std::optional<Posted> posted;
  for (bool dropped = false; !posted;) {
    JobHandle oldest;
    posted = queue_up(job, oldest);
    dropped = dropped || oldest;
    if (oldest) count_lost(*oldest);
    done_with(oldest, true);
    if (posted) posted->dropped_oldest = dropped;
  }
  done_with(job, true);
  return *posted;
}

/// Leaves in `job` what was not queued, and in `oldest` what had to go for it: these are told of without the
/// lock. Empty if more has to go.
std::optional<Lane::Posted> Lane::queue_up(JobHandle& job, JobHandle& oldest) {
  const std::scoped_lock lock(mutex_);
  if (closed()) return Posted{};
  note_report(*job);
  if (!has_room_for(*job)) {
    oldest = pop_oldest();
    if (!has_room_for(*job)) return {};
  }
  const std::size_t bytes = bytes_held(*job);
  if (late_ && channel_ != nullptr) job->keep();
  if (oldest_ == 0) oldest_ = job->sequence;
  queue_.push_back(std::move(job));
  queued_bytes_ += bytes;
  busy_.store(true, std::memory_order_relaxed);
  const bool was_idle = !held_ && !std::exchange(scheduled_, true);
  return Posted{.wake = was_idle ? Wake::schedule : Wake::none};
}

bool Lane::has_room() {
  const std::scoped_lock lock(mutex_);
  return queue_.size() < depth_ && !closed();
}

void Lane::done_with(const JobHandle& job, bool lost) const {
  if (const std::shared_ptr<LaneListener> listener = listener_.lock(); listener && job)
    listener->departed(*job, lost);
}

bool Lane::has_room_for(const Job& job) const {
  if (queue_.size() < depth_) return true;
  if (!late_ && !(job.is_small() && may_pile_up(Clock::now()))) return false;
  const std::size_t bytes = queued_bytes_ + bytes_held(job);
  const std::size_t jobs_max = late_ ? late_jobs_max : unproven_jobs_max;
  if (channel_ == nullptr) return queue_.size() < jobs_max && bytes <= late_bytes_max;
  return queue_.size() < channel_limits.samples && bytes <= channel_limits.bytes &&
         !channel_->must_give_up_some_of(bytes);
}

/// Before the first report of the receiver, and for a moment after it.
bool Lane::may_pile_up(Clock::time_point now) const {
  if (unproven_) return !to_->window().is_mute(now);
  return reported_at_ && now - *reported_at_ < pile_lasts;
}

void Lane::note_report(const Job& job) {
  unproven_ = !to_->window().answers();
  if (unproven_) {
    small_ones_wait_ = small_ones_wait_ || job.is_small();
    reported_at_.reset();
  } else if (std::exchange(small_ones_wait_, false)) {
    reported_at_ = Clock::now();
  }
}

void Lane::await_room(const Job& job, std::chrono::nanoseconds& patience) {
  std::unique_lock lock(mutex_);
  note_report(job);
  if (closed() || has_room_for(job)) return;
  const Clock::time_point begin = Clock::now();
  room_.wait_until(lock, begin + patience, [&] { return closed() || has_room_for(job); });
  patience = std::max<std::chrono::nanoseconds>(patience - (Clock::now() - begin), {});
}

/// REQUIRES: the mutex is held, and the queue is not empty.
JobHandle Lane::pop_oldest() {
  JobHandle oldest = std::move(queue_[queue_.begin()]);
  queue_.pop_front();
  queued_bytes_ -= bytes_held(*oldest);
  return oldest;
}

void Lane::lose_current() {
  tally_->dropped.fetch_add(current_->samples(), std::memory_order_relaxed);
  is_lost_ = true;
  if (!is_retained_) count_lost(*current_);
}

void Lane::count_lost(const Job& job) const {
  const std::uint32_t whole_bytes = job.is_pack() ? job.whole_bytes
                                    : job.sample  ? job.sample->whole_bytes
                                                  : 0;
  losses_->lost(job.first.total, whole_bytes, job.samples());
}

void Lane::mark(Job& job) {
  const std::scoped_lock lock(mutex_);
  if (oldest_ == 0) oldest_ = job.sequence;
  job.first.history.oldest = oldest_;
}

Wake Lane::begin(std::vector<JobHandle> history) {
  const std::scoped_lock lock(mutex_);
  if (!std::exchange(held_, false) || closed()) return Wake::none;
  std::reverse(history.begin(), history.end());
  history_ = std::move(history);
  if (!history_.empty()) oldest_ = history_.back()->sequence;
  scheduled_ = !history_.empty() || !queue_.empty();
  busy_.store(scheduled_, std::memory_order_release);
  return scheduled_ ? Wake::schedule : Wake::none;
}

bool Lane::history_has_departed() const {
  if (!idle()) return false;
  const std::uint64_t last = last_retained_.load(std::memory_order_acquire);
  return last == 0 || channel_ == nullptr || channel_->closed() || !channel_->keeps(last);
}

void Lane::passed_on(std::uint64_t ordinal) {
  if (is_retained_) last_retained_.store(ordinal, std::memory_order_release);
}

const Job* Lane::next() {
  done_with(current_, std::exchange(is_lost_, false));
  current_ = {};
  const std::scoped_lock lock(mutex_);
  is_retained_ = !history_.empty();
  if (is_retained_) {
    current_ = std::move(history_.back());
    history_.pop_back();
  } else if (!queue_.empty()) {
    current_ = pop_oldest();
    room_.notify_one();
  } else {
    scheduled_ = false;
    busy_.store(false, std::memory_order_release);
    return nullptr;
  }
  if ((current_->first.flags & history_follows) != 0) current_->first.history.oldest = oldest_;
  return &*current_;
}

void Lane::close() {
  // These go outside of the lock.
  OrdinalRing<JobHandle> dropped{0};
  std::vector<JobHandle> dropped_history;
  {
    const std::scoped_lock lock(mutex_);
    closed_.store(true, std::memory_order_release);
    room_.notify_one();
    std::swap(dropped, queue_);
    queued_bytes_ = 0;
    dropped_history.swap(history_);
  }
  for (std::uint64_t n = dropped.begin(); n != dropped.end(); ++n) done_with(dropped[n], true);
}

}  // namespace sft::udp
