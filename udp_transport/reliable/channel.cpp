#include "udp_transport/reliable/channel.h"

#include <algorithm>
#include <utility>

namespace sft::udp {

namespace {
/// About so many kept bytes stay in the caches. With fewer samples sending would pause.
constexpr std::size_t cached_bytes_max = std::size_t{8} << 20, cached_samples_min = 2;
/// A large sample departs within this time on a fast link. On a slow link, or after an ack was lost, a longer
/// pause would not help.
constexpr std::chrono::milliseconds moment{10};
}  // namespace

/// True if the window can keep the job, or if the channel has ended.
bool Channel::has_room_for(const Job& job) const {
  return closed_ || ended_at_ || window_.can_keep(job.samples(), job.held_bytes_in_all());
}

bool Channel::runs_ahead_with(const Job& job) const {
  if (!has_room_for(job)) return true;
  if (closed_ || ended_at_ || window_.kept() < cached_samples_min) return false;
  return window_.kept_bytes() + job.held_bytes_in_all() > cached_bytes_max;
}

/// With the mutex held, but not while the call waits. False if it did not have to wait.
bool Channel::wait_for_room(const Job& job, std::chrono::nanoseconds& patience,
                            std::unique_lock<std::mutex>& lock) {
  if (!runs_ahead_with(job)) [[likely]]
    return false;
  const Time begin = now();
  awaits_room_ = true;
  room_.wait_until(lock, begin + std::min<std::chrono::nanoseconds>(patience, moment),
                   [&] { return !runs_ahead_with(job); });
  room_.wait_until(lock, begin + patience, [&] { return has_room_for(job); });
  awaits_room_ = false;
  patience = std::max(patience - (now() - begin), std::chrono::nanoseconds{0});
  return true;
}

/// REQUIRES: the mutex is held.
Wake Channel::attend() {
  if (std::exchange(attended_, true)) return Wake::none;
  looks_at_ = {};  // at once
  return Wake::schedule;
}

Channel::Posted Channel::post(JobHandle job, const FirstHeader& first, bool at_once,
                              std::chrono::nanoseconds* patience) {
  Posted posted;
  std::unique_lock lock(mutex_);
  posted.waited = patience != nullptr && wait_for_room(*job, *patience, lock);
  job->keep();
  const std::size_t samples = job->samples();
  posted.kept = window_.keep(std::move(job), first);
  if (at_once) posted.piece = window_.take(posted.kept.ordinal);
  posted.wake = attend();
  const bool some_remains = !posted.piece || posted.piece->samples < samples;
  if (some_remains && !std::exchange(woken_, true)) posted.wake = strongest(posted.wake, Wake::look);
  return posted;
}

std::optional<Channel::Posted> Channel::post_ahead(const JobHandle& job, const FirstHeader& first,
                                                   std::chrono::nanoseconds* patience) {
  Posted posted;
  std::unique_lock lock(mutex_);
  posted.waited = patience != nullptr && wait_for_room(*job, *patience, lock);
  if (!window_.all_sent()) return {};
  job->keep();
  posted.kept = window_.keep(job, first);
  posted.piece = window_.take(posted.kept.ordinal);
  posted.wake = attend();
  return posted;
}

bool Channel::has_room(const Job& job) {
  const std::scoped_lock lock(mutex_);
  return has_room_for(job);
}

bool Channel::has_room_or_tells(const Job& job) {
  const std::scoped_lock lock(mutex_);
  const bool has_room = has_room_for(job);
  tells_of_room_ = !has_room;
  return has_room;
}

bool Channel::keeps(std::uint64_t ordinal) {
  const std::scoped_lock lock(mutex_);
  return window_.keeps(ordinal);
}

Channel::Posted Channel::post_shared(JobHandle job, const FirstHeader& first, bool elsewhere) {
  job->keep();
  const std::scoped_lock lock(mutex_);
  Posted posted;
  posted.kept = window_.keep(std::move(job), first, elsewhere);
  posted.wake = attend();
  if (!posted.kept.elsewhere && !std::exchange(woken_, true))
    posted.wake = strongest(posted.wake, Wake::look);
  return posted;
}

JobHandle Channel::sent_elsewhere(std::uint64_t ordinal) {
  const std::scoped_lock lock(mutex_);
  return window_.sent_elsewhere(ordinal);
}

Wake Channel::departed(std::uint64_t ordinal) {
  const Time time = now();
  const std::scoped_lock lock(mutex_);
  window_.departed(ordinal, time);
  return attended_ ? looks_sooner(time) : Wake::none;
}

/// REQUIRES: the mutex is held. Wakes the sending thread if it has to look at this channel sooner than it
/// would.
Wake Channel::looks_sooner(Time now) {
  if (window_.next_look(now) >= looks_at_) return Wake::none;
  looks_at_ = now;
  return Wake::look;
}

Wake Channel::finished(const Piece& piece, Time now) {
  const std::scoped_lock lock(mutex_);
  window_.finished(piece, now);
  return attended_ ? looks_sooner(now) : Wake::none;
}

void Channel::put_back(const Piece& piece) {
  const std::scoped_lock lock(mutex_);
  window_.put_back(piece);
}

Wake Channel::hear(const Ack& ack) {
  const Time time = now();
  const Time::duration round_trip = ack.missing_count == 0 ? Time::duration{} : to_->round_trip();
  const std::scoped_lock lock(mutex_);
  if (ack.channel == number_) judge_length(ack, time);
  window_.hear(ack, time, round_trip);
  if (window_.gone_wrong() && !closed_ && !went_wrong_.exchange(true, std::memory_order_relaxed)) {
    room_.notify_all();
    tally_->dropped.fetch_add(window_.kept(), std::memory_order_relaxed);
    return Wake::look;
  }
  if (awaits_room_) room_.notify_one();
  const Wake for_room = std::exchange(tells_of_room_, false) ? Wake::look : Wake::none;
  if (!attended_) return for_room;
  const Wake sooner = looks_sooner(time);
  const bool has_news = window_.has_work() && !std::exchange(woken_, true);
  return has_news ? Wake::look : strongest(sooner, for_room);
}

/// Looks at the samples that do not fit into one datagram. The path drops long datagrams if all of these are
/// asked for, although short ones get through, as this ack did.
void Channel::judge_length(const Ack& ack, Time now) {
  const std::size_t length = to_->datagram_bytes();
  if (std::exchange(length_, length) != length) sent_so_from_ = window_.end();
  const auto is_long = [&](std::uint64_t ordinal) {
    const auto bytes = window_.bytes_sent(ordinal);
    return bytes && *bytes + following_header_bytes > length;
  };
  if (to_->length_in_doubt()) {
    for (std::uint64_t ordinal = std::max(sent_so_from_, window_.begin());
         ordinal < std::min(ack.next, window_.end()); ++ordinal) {
      if (!is_long(ordinal)) continue;
      to_->long_ones_arrived(now);
      break;
    }
    sent_so_from_ = std::max(sent_so_from_, std::min(ack.next, window_.end()));
  }
  const auto lacks_all = [&](const Missing& part) {
    if (part.ordinal != static_cast<std::uint32_t>(ack.next) || !is_long(ack.next)) return false;
    return part.begin == 0 && (part.end == 0 || part.end + length > *window_.bytes_sent(ack.next));
  };
  if (std::ranges::any_of(ack.parts(), lacks_all)) to_->long_ones_were_lost(now);
}

void Channel::end() {
  const std::scoped_lock lock(mutex_);
  if (!ended_at_) ended_at_ = now();
  room_.notify_one();
}

void Channel::close() {
  const std::scoped_lock lock(mutex_);
  closed_ = true;
  room_.notify_one();
}

bool Channel::closed() {
  const std::scoped_lock lock(mutex_);
  return closed_ || ended_at_ || went_wrong();
}

std::optional<Channel::Piece> Channel::next(ResendWindow::Size size) {
  const Time time = now();
  const std::scoped_lock lock(mutex_);
  woken_ = false;
  return window_.next(size, time);
}

Channel::Care Channel::look_after() {
  const Time time = now();
  const std::scoped_lock lock(mutex_);
  if (closed_ || (window_.settled() && !went_wrong())) {
    attended_ = false;
    return {.at_rest = true};
  }
  if (went_wrong() || (ended_at_ && time - *ended_at_ > linger)) {
    closed_ = true;
    return {.heartbeat = addressed(window_.parting()), .at_rest = true};
  }
  if (to_->moves() != std::exchange(moves_, to_->moves())) window_.way_changed(time);
  Care care;
  if (const auto heartbeat = window_.heartbeat(time)) care.heartbeat = addressed(*heartbeat);
  care.next_look = window_.next_look(time);
  if (ended_at_)
    care.next_look = std::min(care.next_look, *ended_at_ + linger + std::chrono::milliseconds(1));
  looks_at_ = care.next_look;
  return care;
}

}  // namespace sft::udp
