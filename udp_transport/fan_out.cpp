#include "udp_transport/fan_out.h"

#include <algorithm>
#include <thread>
#include <utility>

namespace sft::udp {

namespace {
/// Small samples come in bursts, and hold little memory.
constexpr std::size_t small_samples_max = 64;
}  // namespace

FanOut::FanOut(const core::WriterSpec& spec, std::shared_ptr<SendSide> side,
               std::shared_ptr<WriterTally> tally, std::shared_ptr<JobPool> jobs)
    : side_(side), tally_(tally), sender_(spec, std::move(side), std::move(tally), std::move(jobs)) {
  queue_.reserve(std::max(small_samples_max, side_->queue_depth));
}

FanOut::Posted FanOut::post(Rest rest) noexcept {
  const bool small = rest.sample->capacity <= direct_bytes_max;
  const std::size_t depth = std::max<std::size_t>(small ? small_samples_max : side_->queue_depth, 1);
  for (bool dropped = false;; dropped = true) {
    Rest oldest;  // goes outside the lock
    const std::scoped_lock lock(mutex_);
    if (queue_.size() < depth) {
      queue_.push_back(std::move(rest));
      return {.was_idle = done_.exchange(false, std::memory_order_relaxed), .dropped_oldest = dropped};
    }
    oldest = std::move(queue_.front());
    queue_.erase(queue_.begin());
    count_dropped(oldest);
  }
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
  while (!done() && !side_->sender.stopped()) std::this_thread::yield();
}

}  // namespace sft::udp
