// The getters of one recorded sample note here which leaves they read, one bit per leaf. Any number of
// threads may read the sample.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

namespace sft::detail {

/// The leaves that were read, of 64. There are two words, so that one bit tells a getter both that there is
/// nothing left to note and that it has something to return.
struct AccessWord {
  std::atomic<std::uint64_t> found{0};   ///< and the sample has them
  std::atomic<std::uint64_t> missed{0};  ///< and it does not
};

class AccessLog {
 public:
  class Listener {
   public:
    /// Called at the first access in this sample to a leaf, on the reading thread: it must not block.
    virtual void first_read(std::size_t leaf) noexcept = 0;

   protected:
    ~Listener() = default;
  };

  /// `words` has room for all leaves, is zero at first and outlives the log; `listener` may be null.
  AccessLog(std::span<AccessWord> words, Listener* listener) : words_(words.data()), listener_(listener) {}

  /// True if the leaf was read before, and the sample has it.
  bool has_found(std::size_t leaf) const noexcept {
    return (words_[leaf / 64].found.load(std::memory_order_relaxed) & bit(leaf)) != 0;
  }

  /// Notes an access. A sample has a leaf or does not: `present` is the same each time.
  void touch(std::size_t leaf, bool present) noexcept {
    AccessWord& word = words_[leaf / 64];
    std::atomic<std::uint64_t>& read = present ? word.found : word.missed;
    if ((read.load(std::memory_order_relaxed) & bit(leaf)) != 0) return;
    const bool first = (read.fetch_or(bit(leaf), std::memory_order_relaxed) & bit(leaf)) == 0;
    if (first && listener_ != nullptr) listener_->first_read(leaf);
  }

 private:
  static constexpr std::uint64_t bit(std::size_t leaf) { return std::uint64_t{1} << (leaf % 64); }

  AccessWord* words_;
  Listener* listener_;
};

}  // namespace sft::detail
