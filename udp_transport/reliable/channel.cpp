#include "udp_transport/reliable/channel.h"

#include <algorithm>
#include <utility>

namespace sft::udp {

namespace {
/// The number of kept bytes that fit into a processor's caches, and the minimum number of kept samples with
/// which sending does not pause.
constexpr std::size_t cached_bytes_max = std::size_t{8} << 20, cached_samples_min = 2;
/// The maximum time of waiting until kept samples fit into the caches. A fast link sends a large sample
/// within this time. On a slow link, or after a lost ack, a longer wait would not help.
constexpr std::chrono::milliseconds moment{10};

Channel::Time now() { return std::chrono::steady_clock::now(); }

Heartbeat addressed(Heartbeat heartbeat, std::uint16_t port) {
  heartbeat.port = port;
  return heartbeat;
}
}  // namespace

/// Returns true if no reader needs what is posted from now on. So no publisher waits for room.
bool Channel::has_ended() const { return life_.has_ended() || went_wrong(); }

/// Returns true if the window can keep the job without giving up older samples, or if the channel has ended.
bool Channel::has_room_for(const Job& job) const {
  return has_ended() || window_.can_keep(job.samples(), job.held_bytes_in_all());
}

bool Channel::runs_ahead_with(const Job& job) const {
  if (!has_room_for(job)) return true;
  if (has_ended() || window_.kept() < cached_samples_min) return false;
  return window_.kept_bytes() + job.held_bytes_in_all() > cached_bytes_max;
}

/// Waits until the channel can keep the job, with the mutex unlocked. Returns false if it did not have to
/// wait.
bool Channel::wait_for_room(const Job& job, std::chrono::nanoseconds& timeout, core::Lock& lock) {
  if (!runs_ahead_with(job)) [[likely]]
    return false;
  const Time begin = now();
  const Time at_most = begin + timeout;
  const Time until = begin + std::min<std::chrono::nanoseconds>(timeout, moment);
  while (runs_ahead_with(job) && waiters_.wait_until(lock, until)) {
  }
  while (!has_room_for(job) && waiters_.wait_until(lock, at_most)) {
  }
  timeout = std::max(timeout - (now() - begin), std::chrono::nanoseconds{0});
  return true;
}

Channel::Posted Channel::post(JobHandle job, const FirstHeader& first, bool at_once,
                              std::chrono::nanoseconds* timeout) {
  Posted posted;
  core::Lock lock(mutex_);
  posted.waited = timeout != nullptr && wait_for_room(*job, *timeout, lock);
  job->keep();
  const std::size_t samples = job->samples();
  posted.kept = window_.keep(std::move(job), first);
  if (at_once) posted.piece = window_.take(posted.kept.ordinal);
  posted.wake = attention_.attract();
  const bool some_remains = !posted.piece || posted.piece->samples < samples;
  if (some_remains) posted.wake = strongest(posted.wake, attention_.wake());
  return posted;
}

std::optional<Channel::Posted> Channel::post_ahead(const JobHandle& job, const FirstHeader& first,
                                                   std::chrono::nanoseconds* timeout) {
  Posted posted;
  core::Lock lock(mutex_);
  posted.waited = timeout != nullptr && wait_for_room(*job, *timeout, lock);
  if (!window_.all_sent()) return {};
  job->keep();
  posted.kept = window_.keep(job, first);
  posted.piece = window_.take(posted.kept.ordinal);
  posted.wake = attention_.attract();
  return posted;
}

bool Channel::await_room(const Job& job, std::chrono::nanoseconds* timeout) {
  core::Lock lock(mutex_);
  if (timeout != nullptr) wait_for_room(job, *timeout, lock);
  return has_room_for(job);
}

bool Channel::has_room_or_waits(const Job& job) {
  const core::Lock lock(mutex_);
  const bool has_room = has_room_for(job);
  waiters_.note_sending_thread(!has_room);
  return has_room;
}

bool Channel::keeps(std::uint64_t ordinal) {
  const core::Lock lock(mutex_);
  return window_.keeps(ordinal);
}

Channel::Posted Channel::post_shared(JobHandle job, const FirstHeader& first, bool elsewhere) {
  job->keep();
  const core::Lock lock(mutex_);
  Posted posted;
  posted.kept = window_.keep(std::move(job), first, elsewhere);
  posted.wake = attention_.attract();
  if (!posted.kept.elsewhere) posted.wake = strongest(posted.wake, attention_.wake());
  return posted;
}

JobHandle Channel::sent_elsewhere(std::uint64_t ordinal) {
  const core::Lock lock(mutex_);
  return window_.sent_elsewhere(ordinal);
}

Wake Channel::departed(std::uint64_t ordinal) {
  const Time time = now();
  const core::Lock lock(mutex_);
  window_.departed(ordinal, time);
  return looks_sooner(time);
}

/// Returns the Wake with which the sending thread checks this channel earlier than planned; Wake::none if
/// the planned check is early enough.
Wake Channel::looks_sooner(Time now) {
  return attention_.is_paid() ? attention_.look_by(window_.next_look(now), now) : Wake::none;
}

Wake Channel::finished(const Piece& piece, Time now) {
  const core::Lock lock(mutex_);
  window_.finished(piece, now);
  return looks_sooner(now);
}

void Channel::put_back(const Piece& piece) {
  const core::Lock lock(mutex_);
  window_.put_back(piece);
}

Wake Channel::hear(const Ack& ack) {
  const Time time = now();
  if (ack.channel == number_ && ack.missing_count > 0) to_->asked_again();
  const Time::duration round_trip = ack.missing_count == 0 ? Time::duration{} : to_->window().round_trip();
  const core::Lock lock(mutex_);
  window_.hear(ack, time, round_trip);
  if (window_.gone_wrong() && !life_.is_closed() && !went_wrong_.exchange(true, std::memory_order_relaxed)) {
    waiters_.release_publisher();
    tally_->dropped.fetch_add(window_.kept(), std::memory_order_relaxed);
    return Wake::look;
  }
  const Wake for_room = waiters_.notify();
  if (!attention_.is_paid()) return for_room;
  const Wake sooner = looks_sooner(time);
  const Wake news = window_.has_work() ? attention_.wake() : Wake::none;
  return strongest(strongest(sooner, for_room), news);
}

void Channel::end() {
  const core::Lock lock(mutex_);
  life_.end(now());
  waiters_.release_publisher();
}

void Channel::close() {
  const core::Lock lock(mutex_);
  life_.close();
  waiters_.release_publisher();
}

bool Channel::closed() {
  const core::Lock lock(mutex_);
  return has_ended();
}

std::optional<Channel::Piece> Channel::next(ResendWindow::Size size) {
  const Time time = now();
  const core::Lock lock(mutex_);
  attention_.looks();
  return window_.next(size, time);
}

Channel::Care Channel::look_after() {
  const Time time = now();
  const core::Lock lock(mutex_);
  if (life_.is_closed() || (window_.settled() && !went_wrong())) {
    attention_.rest();
    return {.at_rest = true};
  }
  if (went_wrong() || life_.has_lingered(time)) {
    life_.close();
    return {.heartbeat = addressed(window_.parting(), port_), .at_rest = true};
  }
  // The number is read only once. A move between two reads would never be noticed.
  const std::uint32_t moves = to_->moves();
  if (std::exchange(moves_, moves) != moves) window_.way_changed(time);
  Care care;
  if (const auto heartbeat = window_.heartbeat(time)) care.heartbeat = addressed(*heartbeat, port_);
  care.next_look = life_.next_look(window_.next_look(time));
  attention_.looks_again_by(care.next_look);
  return care;
}

}  // namespace sft::udp
