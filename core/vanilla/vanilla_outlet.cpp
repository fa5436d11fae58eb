#include "core/vanilla/vanilla_outlet.h"

#include <algorithm>
#include <utility>

namespace sft::core {

VanillaOutlet::VanillaOutlet(Write write, std::size_t retained_max)
    : write_(std::move(write)), retained_max_(retained_max), waiting_(std::max(waiting_max, retained_max)) {}

Result<void> VanillaOutlet::start(const ThreadSpec& thread) {
  Result<std::thread> started = start_thread(thread, [this] { run(); });
  if (!started) return tl::unexpected(started.error());
  thread_ = std::move(*started);
  return {};
}

void VanillaOutlet::close() {
  {
    const Lock lock(mutex_);
    closed_ = true;
  }
  arrived_.notify_one();
  if (thread_.joinable()) thread_.join();
  retained_.clear();
  for (;;) {
    SampleHandle gone;  // destroyed after the lock is released
    const Lock lock(mutex_);
    if (count_ == 0) break;
    gone = take_oldest();
  }
  write_ = {};
}

/// The handles of dropped samples are released without the lock.
void VanillaOutlet::send(const SampleHandle& sample) noexcept {
  for (;;) {
    SampleHandle oldest;
    const Lock lock(mutex_);
    if (closed_) return;
    if (put(sample, oldest)) break;
  }
  arrived_.notify_one();
}

/// Returns false if the sample did not fit. Then the oldest sample was removed and is in `oldest`, and the
/// caller has to try again.
bool VanillaOutlet::put(const SampleHandle& sample, SampleHandle& oldest) noexcept {
  const bool is_full = count_ == waiting_.size();
  const bool is_too_much =
      count_ >= std::max<std::size_t>(retained_max_, 1) && bytes_ + sample->capacity > waiting_bytes_max;
  if (is_full || is_too_much) {
    oldest = take_oldest();
    left_out_.fetch_add(1, std::memory_order_relaxed);
    return false;
  }
  waiting_[(first_ + count_++) % waiting_.size()] = sample;
  bytes_ += sample->capacity;
  return true;
}

SampleHandle VanillaOutlet::take_oldest() noexcept {
  SampleHandle oldest = std::move(waiting_[first_]);
  first_ = (first_ + 1) % waiting_.size();
  --count_;
  bytes_ -= oldest->capacity;
  return oldest;
}

bool VanillaOutlet::is_closed() {
  const Lock lock(mutex_);
  return closed_;
}

/// Writes the retained samples, and then the waiting samples. A sample that is both retained and waiting is
/// written once.
void VanillaOutlet::run() {
  std::uint64_t written = 0;  // the greatest sequence that was written
  const auto write = [&](const SampleHandle& sample) {
    if (sample->sequence <= written) return;
    written = sample->sequence;
    if (!write_(sample)) left_out_.fetch_add(1, std::memory_order_relaxed);
  };
  for (const SampleHandle& sample : std::exchange(retained_, {})) {
    if (is_closed()) return;
    write(sample);
  }
  for (;;) {
    SampleHandle sample;
    {
      Lock lock(mutex_);
      while (count_ == 0 && !closed_) arrived_.wait(lock);
      if (closed_) return;
      sample = take_oldest();
    }
    write(sample);
  }
}

}  // namespace sft::core
