#include "udp_transport/fan_out.h"

#include <algorithm>
#include <utility>

#include "core/backoff.h"

namespace sft::udp {

namespace {
/// In all. Of large ones there may be as many as in a lane: they hold much memory.
constexpr std::size_t samples_max = 64;
}  // namespace

FanOut::FanOut(const core::WriterSpec& spec, std::shared_ptr<SendSide> side,
               std::shared_ptr<WriterTally> tally, std::shared_ptr<JobPool> jobs)
    : side_(side), tally_(tally), sender_(spec, std::move(side), std::move(tally), std::move(jobs)) {
  queue_.reserve(samples_max);
}

FanOut::Posted FanOut::post(Rest rest) noexcept {
  Rest oldest;  // goes outside the lock
  const std::scoped_lock lock(mutex_);
  const auto surplus = surplus_before(rest);
  const bool too_many = surplus != queue_.end();
  if (too_many) {
    oldest = std::move(*surplus);
    queue_.erase(surplus);
    count_dropped(oldest);
  }
  queue_.push_back(std::move(rest));
  return {.was_idle = done_.exchange(false, std::memory_order_relaxed), .dropped_oldest = too_many};
}

/// What has to go for another one: the oldest, or the oldest large one where there are too many of these.
std::vector<FanOut::Rest>::iterator FanOut::surplus_before(const Rest& newcomer) noexcept {
  if (queue_.size() >= samples_max) return queue_.begin();
  const auto large = static_cast<std::size_t>(std::count_if(queue_.begin(), queue_.end(), is_large));
  const bool too_many = is_large(newcomer) && large >= std::max<std::size_t>(side_->queue_depth, 1);
  return too_many ? std::find_if(queue_.begin(), queue_.end(), is_large) : queue_.end();
}

void FanOut::count_dropped(const Rest& rest) noexcept {
  for (const Group& group : of(rest)) {
    if (group.gate == nullptr) group.tally->dropped();
  }
}

std::optional<FanOut::Rest> FanOut::take() noexcept {
  const std::scoped_lock lock(mutex_);
  if (queue_.empty()) {
    done_.store(true, std::memory_order_release);
    return std::nullopt;
  }
  Rest rest = std::move(queue_.front());
  queue_.erase(queue_.begin());
  return rest;
}

void FanOut::carry_out() noexcept {
  while (const std::optional<Rest> rest = take()) {
    for (const Group& group : of(*rest)) {
      if (group.gate == nullptr)
        tally_->dropped.fetch_add(sender_.send(group, rest->sample), std::memory_order_relaxed);
    }
  }
}

void FanOut::finish() noexcept {
  core::wait_until([this] { return done() || side_->sender.stopped(); });
}

}  // namespace sft::udp
