#include "udp_transport/send/fan_out.h"

#include <algorithm>
#include <new>
#include <utility>

#include "core/sync/backoff.h"

namespace sft::udp {

namespace {
/// In all. Of large ones there may be as many as in a lane: they hold much memory.
constexpr std::size_t samples_max = 64;
// Of what is sent reliably, as much as a channel keeps: nothing repairs what never got into one.
constexpr std::size_t reliable_samples_max = ResendLimits{}.samples;
constexpr std::size_t reliable_bytes_max = ResendLimits{}.bytes;
}  // namespace

FanOut::FanOut(const core::WriterSpec& spec, std::shared_ptr<SendSide> side,
               std::shared_ptr<WriterTally> tally, std::shared_ptr<JobPool> jobs)
    : side_(side), tally_(tally), sender_(spec, std::move(side), std::move(tally), std::move(jobs)) {}

FanOut::Posted FanOut::post(Rest rest) noexcept try {
  Posted posted;
  while (const std::optional<Rest> surplus = take_surplus_before(rest)) {
    count_dropped(*surplus);
    posted.dropped_oldest = true;
  }
  const std::scoped_lock lock(mutex_);
  const std::size_t bytes = rest.sample->capacity;
  queue_.push_back(std::move(rest));
  queued_bytes_ += bytes;
  posted.was_idle = done_.exchange(false, std::memory_order_relaxed);
  return posted;
} catch (const std::bad_alloc&) {
  count_dropped(rest);
  return {.dropped_oldest = true};
}

/// What has to go for another one: the oldest, or the oldest large one where there are too many of these.
std::optional<FanOut::Rest> FanOut::take_surplus_before(const Rest& newcomer) noexcept {
  const std::scoped_lock lock(mutex_);
  if (queue_.empty()) return {};
  if (is_reliable(newcomer)) {
    const bool fits = queue_.size() < reliable_samples_max &&
                      queued_bytes_ + newcomer.sample->capacity <= reliable_bytes_max;
    return fits ? std::nullopt : std::optional(pop_oldest());
  }
  if (queue_.size() >= samples_max) return pop_oldest();
  std::size_t large = 0;
  std::uint64_t oldest_large = queue_.end();
  for (std::uint64_t i = queue_.end(); i-- > queue_.begin();) {
    if (!is_large(queue_[i])) continue;
    oldest_large = i;
    ++large;
  }
  if (!is_large(newcomer) || large < std::max<std::size_t>(side_->queue_depth, 1)) return {};
  for (std::uint64_t i = oldest_large; i > queue_.begin(); --i) std::swap(queue_[i], queue_[i - 1]);
  return pop_oldest();
}

bool FanOut::is_reliable(const Rest& rest) {
  return std::ranges::any_of(of(rest), [](const Group& group) {
    return std::ranges::any_of(group.channels, [](const auto& channel) { return channel != nullptr; });
  });
}

/// With the mutex held; there is one.
FanOut::Rest FanOut::pop_oldest() noexcept {
  Rest oldest = std::move(queue_[queue_.begin()]);
  queue_.pop_front();
  queued_bytes_ -= oldest.sample->capacity;
  return oldest;
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
  return pop_oldest();
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
