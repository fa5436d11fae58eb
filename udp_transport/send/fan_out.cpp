#include "udp_transport/send/fan_out.h"

#include <algorithm>
#include <chrono>
#include <new>
#include <utility>

#include "core/sync/backoff.h"

namespace sft::udp {

namespace {
/// The maximum number of deferred best-effort samples. Large samples of these are limited to the depth of a
/// lane, because they hold much memory.
constexpr std::size_t samples_max = 64;

using Clock = std::chrono::steady_clock;
/// The maximum number of samples that are sent for one writer before other writers have their turn.
constexpr std::size_t samples_per_turn = 16;
constexpr std::chrono::milliseconds turn{1};
}  // namespace

FanOut::FanOut(const core::WriterSpec& spec, std::shared_ptr<SendSide> side,
               std::shared_ptr<WriterTally> tally, std::shared_ptr<JobPool> jobs)
    : side_(side),
      tally_(tally),
      takes_large_(spec.asynchronous),
      sender_(spec, std::move(side), std::move(tally), std::move(jobs)) {}

FanOut::Posted FanOut::post(DeferredSample deferred) noexcept {
  Posted posted;
  while (const std::optional<DeferredSample> surplus = take_surplus_before(deferred)) {
    count_dropped(*surplus);
    ++posted.dropped;
  }
  try {
    const core::Lock lock(mutex_);
    const std::size_t bytes = deferred.sample->capacity;
    queue_.push_back(std::move(deferred));
    queued_bytes_ += bytes;
    if (done_.exchange(false, std::memory_order_relaxed)) posted.wake = Wake::schedule;
  } catch (const std::bad_alloc&) {
    count_dropped(deferred);
    ++posted.dropped;
  }
  if (posted.dropped > 0) side_->over_limit.fetch_add(posted.dropped, std::memory_order_relaxed);
  return posted;
}

/// If a limit is reached, removes and returns a sample that has to be dropped for `newcomer`: the oldest
/// sample, or the oldest large sample if too many large samples wait. The limits of reliable samples are
/// those of a channel, because a sample that was dropped before it came into a channel cannot be repaired.
std::optional<FanOut::DeferredSample> FanOut::take_surplus_before(const DeferredSample& newcomer) noexcept {
  const core::Lock lock(mutex_);
  if (queue_.empty()) return {};
  if (is_reliable(newcomer)) {
    const ResendLimits& limits = tally_->resend;
    const std::size_t samples = queue_.size() + 1, bytes = queued_bytes_ + newcomer.sample->capacity;
    const bool fits = samples <= limits.samples && (bytes <= limits.bytes || samples <= limits.samples_least);
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

bool FanOut::is_reliable(const DeferredSample& deferred) {
  return std::ranges::any_of(audiences_of(deferred), [](const Audience& audience) {
    return std::ranges::any_of(audience.channels, [](const auto& channel) { return channel != nullptr; });
  });
}

FanOut::DeferredSample FanOut::pop_oldest() noexcept {
  DeferredSample oldest = std::move(queue_[queue_.begin()]);
  queue_.pop_front();
  queued_bytes_ -= oldest.sample->capacity;
  return oldest;
}

void FanOut::count_dropped(const DeferredSample& deferred) noexcept {
  for (const Audience& audience : audiences_of(deferred)) {
    if (audience.gate == nullptr) audience.tally->dropped();
  }
}

std::optional<FanOut::DeferredSample> FanOut::take() noexcept {
  const core::Lock lock(mutex_);
  if (queue_.empty()) {
    done_.store(true, std::memory_order_release);
    return std::nullopt;
  }
  return pop_oldest();
}

/// The number of samples per call is limited. Otherwise a publisher that defers samples as fast as they are
/// sent would keep the sending thread in this function.
bool FanOut::carry_out() noexcept {
  const auto until = Clock::now() + turn;
  for (std::size_t samples = 0; samples < samples_per_turn; ++samples) {
    if (samples > 0 && Clock::now() >= until) return true;
    const std::optional<DeferredSample> deferred = take();
    if (!deferred) return false;
    for (const Audience& audience : audiences_of(*deferred)) {
      if (audience.gate == nullptr)
        tally_->dropped.fetch_add(sender_.send(audience, deferred->sample), std::memory_order_relaxed);
    }
  }
  return true;
}

void FanOut::finish() noexcept {
  core::wait_until([this] { return done() || side_->sender.stopped(); });
}

}  // namespace sft::udp
