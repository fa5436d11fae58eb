#include "udp_transport/channel.h"

#include <algorithm>
#include <utility>

namespace sft::udp {

Channel::Posted Channel::post(JobHandle job, const FirstHeader& first, bool at_once) {
  const std::scoped_lock lock(mutex_);
  Posted posted;
  posted.kept = window_.keep(std::move(job), first);
  if (at_once) posted.piece = window_.take(posted.kept.ordinal);
  posted.was_at_rest = !std::exchange(attended_, true);
  posted.waits = !posted.piece && !std::exchange(woken_, true);
  return posted;
}

Channel::Posted Channel::post_shared(JobHandle job, const FirstHeader& first, bool elsewhere) {
  const std::scoped_lock lock(mutex_);
  Posted posted;
  posted.kept = window_.keep(std::move(job), first, elsewhere);
  posted.was_at_rest = !std::exchange(attended_, true);
  posted.waits = !posted.kept.elsewhere && !std::exchange(woken_, true);
  return posted;
}

JobHandle Channel::sent_elsewhere(std::uint64_t ordinal) {
  const std::scoped_lock lock(mutex_);
  return window_.sent_elsewhere(ordinal);
}

void Channel::left(std::uint64_t ordinal) {
  const Time time = now();
  const std::scoped_lock lock(mutex_);
  window_.left(ordinal, time);
}

void Channel::finished(const Piece& piece) {
  const Time time = now();
  const std::scoped_lock lock(mutex_);
  window_.finished(piece, time);
}

void Channel::put_back(const Piece& piece) {
  const std::scoped_lock lock(mutex_);
  window_.put_back(piece);
}

bool Channel::hear(const Ack& ack) {
  const Time time = now();
  const std::scoped_lock lock(mutex_);
  window_.hear(ack, time);
  return attended_ && window_.has_work() && !std::exchange(woken_, true);
}

void Channel::end() {
  const std::scoped_lock lock(mutex_);
  if (!ended_at_) ended_at_ = now();
}

void Channel::close() {
  const std::scoped_lock lock(mutex_);
  closed_ = true;
}

bool Channel::closed() {
  const std::scoped_lock lock(mutex_);
  return closed_ || ended_at_;
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
  if (window_.settled() || closed_) {
    attended_ = false;
    return {.at_rest = true};
  }
  if (ended_at_ && time - *ended_at_ > linger) {
    closed_ = true;
    return {.heartbeat = addressed(window_.parting()), .at_rest = true};
  }
  Care care;
  if (const auto heartbeat = window_.heartbeat(time)) care.heartbeat = addressed(*heartbeat);
  care.next_look = window_.next_look(time);
  if (ended_at_)
    care.next_look = std::min(care.next_look, *ended_at_ + linger + std::chrono::milliseconds(1));
  return care;
}

}  // namespace sft::udp
