// What the getters of one recorded sample note: one bit per leaf. Any number of threads may read the sample.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

namespace sft {

class AccessLog {
 public:
  /// Told of the first access in this sample to a leaf that the sample does not have. Called on the reading
  /// thread: must not block.
  class MissListener {
   public:
    virtual void missed(std::size_t leaf) noexcept = 0;

   protected:
    ~MissListener() = default;
  };

  /// `words` has room for one bit per leaf, is zero at first and outlives the log; `listener` may be null.
  AccessLog(std::span<std::atomic<std::uint64_t>> words, MissListener* listener)
      : words_(words), listener_(listener) {}

  void touch(std::size_t leaf, bool present) noexcept {
    auto& word = words_[leaf / 64];
    const std::uint64_t bit = std::uint64_t{1} << (leaf % 64);
    if ((word.load(std::memory_order_relaxed) & bit) != 0) return;
    const bool first = (word.fetch_or(bit, std::memory_order_relaxed) & bit) == 0;
    if (first && !present && listener_ != nullptr) listener_->missed(leaf);
  }

 private:
  std::span<std::atomic<std::uint64_t>> words_;
  MissListener* listener_;
};

}  // namespace sft
