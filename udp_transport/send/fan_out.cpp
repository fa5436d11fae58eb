#include "udp_transport/send/fan_out.h"

#include <algorithm>
#include <new>
#include <utility>

#include "core/sync/backoff.h"

namespace sft::udp {

namespace {
/// The most samples in all. There may be as many large ones as in a lane: they hold much memory.
constexpr std::size_t samples_max = 64;
// As many reliable samples may wait as a channel keeps: nothing repairs a sample that never got into a
// channel.
constexpr std::size_t reliable_samples_max = ResendLimits{}.samples;
constexpr std::size_t reliable_bytes_max = ResendLimits{}.bytes;
}  // namespace

FanOut::FanOut(const core::WriterSpec& spec, std::shared_ptr<SendSide> side,
               std::shared_ptr<WriterTally> tally, std::shared_ptr<JobPool> jobs)
    : side_(side),
      tally_(tally),
      takes_large_(spec.asynchronous),
      sender_(spec, std::move(side), std::move(tally), std::move(jobs)) {}

FanOut::Posted FanOut::post(Remainder remainder) noexcept {
  Posted posted;
  while (const std::optional<Remainder> surplus = take_surplus_before(remainder)) {
    count_dropped(*surplus);
    ++posted.dropped;
  }
  try {
    const core::Lock lock(mutex_);
    const std::size_t bytes = remainder.sample->capacity;
    queue_.push_back(std::move(remainder));
    queued_bytes_ += bytes;
    if (done_.exchange(false, std::memory_order_relaxed)) posted.wake = Wake::schedule;
  } catch (const std::bad_alloc&) {
    count_dropped(remainder);
    ++posted.dropped;
  }
  return posted;
}

/// Takes out what has to go for another one: the oldest, or the oldest large one if there are too many of
/// these.
std::optional<FanOut::Remainder> FanOut::take_surplus_before(const Remainder& newcomer) noexcept {
  const core::Lock lock(mutex_);
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

bool FanOut::is_reliable(const Remainder& remainder) {
  return std::ranges::any_of(audiences_of(remainder), [](const Audience& audience) {
    return std::ranges::any_of(audience.channels, [](const auto& channel) { return channel != nullptr; });
  });
}

FanOut::Remainder FanOut::pop_oldest() noexcept {
  Remainder oldest = std::move(queue_[queue_.begin()]);
  queue_.pop_front();
  queued_bytes_ -= oldest.sample->capacity;
  return oldest;
}

void FanOut::count_dropped(const Remainder& remainder) noexcept {
  for (const Audience& audience : audiences_of(remainder)) {
    if (audience.gate == nullptr) audience.tally->dropped();
  }
}

std::optional<FanOut::Remainder> FanOut::take() noexcept {
  const core::Lock lock(mutex_);
  if (queue_.empty()) {
    done_.store(true, std::memory_order_release);
    return std::nullopt;
  }
  return pop_oldest();
}

void FanOut::carry_out() noexcept {
  while (const std::optional<Remainder> remainder = take()) {
    for (const Audience& audience : audiences_of(*remainder)) {
      if (audience.gate == nullptr)
        tally_->dropped.fetch_add(sender_.send(audience, remainder->sample), std::memory_order_relaxed);
    }
  }
}

void FanOut::finish() noexcept {
  core::wait_until([this] { return done() || side_->sender.stopped(); });
}

}  // namespace sft::udp
