// The limit of bytes that wait in the queue of one reader. The writer stores the sizes of the samples that
// it has put into the queue. The reader takes the oldest sample first. So the waiting samples are always
// the newest ones, and the writer can compute their total size from their number alone.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace sft::shm {

/// Each object must be used only by a thread that holds the lock of the writer's port.
class WaitingBytes {
 public:
  static constexpr std::uint64_t any_number = std::numeric_limits<std::uint64_t>::max();

  WaitingBytes() noexcept = default;
  /// `bytes_max` 0: there is no limit. `samples_max` is the maximum number of samples that can wait.
  WaitingBytes(std::uint64_t bytes_max, std::size_t samples_max)
      : bytes_max_(bytes_max), sent_before_(bytes_max == 0 ? 0 : samples_max) {}

  /// Notes that a sample was put into the queue.
  void pushed(std::uint64_t bytes) noexcept {
    if (sent_before_.empty()) return;
    sent_before_[samples_++ % sent_before_.size()] = sent_;
    sent_ += bytes;
  }

  /// Returns the maximum number of samples that may wait in the queue together with a next sample of
  /// `bytes`, so that the total stays within the limit. 0: no other sample may wait. The next sample itself
  /// may always wait, even if it is larger than the limit.
  std::uint64_t beside(std::uint64_t bytes) const noexcept {
    if (sent_before_.empty()) return any_number;
    const std::uint64_t left = bytes_max_ - std::min(bytes_max_, bytes);
    std::uint64_t most = std::min<std::uint64_t>(samples_, sent_before_.size());
    if (of_newest(most) <= left) return any_number;
    // The `fit` newest samples are within `left`, and the `most` newest samples are not.
    std::uint64_t fit = 0;
    while (fit + 1 < most) {
      const std::uint64_t middle = fit + (most - fit) / 2;
      (of_newest(middle) <= left ? fit : most) = middle;
    }
    return fit;
  }

 private:
  std::uint64_t of_newest(std::uint64_t samples) const noexcept {
    return samples == 0 ? 0 : sent_ - sent_before_[(samples_ - samples) % sent_before_.size()];
  }

  std::uint64_t bytes_max_ = 0;
  /// A ring: for each of the last samples, the total size of all samples that were sent before it. Empty:
  /// there is no limit.
  std::vector<std::uint64_t> sent_before_;
  std::uint64_t samples_ = 0, sent_ = 0;  ///< number of samples that were sent, and their total size in bytes
};

}  // namespace sft::shm
