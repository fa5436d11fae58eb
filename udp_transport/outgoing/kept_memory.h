// Counts the memory that all channels of a transport keep for sending lost data again, and limits it. So a
// few slow readers do not use the memory of all publishers of the node.
#pragma once

#include <atomic>
#include <cstddef>
#include <limits>

namespace sft::udp {

/// Any thread may call the functions.
class KeptMemory {
 public:
  explicit KeptMemory(std::size_t limit_bytes = std::numeric_limits<std::size_t>::max() / 2)
      : limit_(limit_bytes) {}

  void add(std::size_t bytes) { used_.fetch_add(bytes, std::memory_order_relaxed); }
  void remove(std::size_t bytes) { used_.fetch_sub(bytes, std::memory_order_relaxed); }
  std::size_t used() const { return used_.load(std::memory_order_relaxed); }

  /// Returns true if a channel that keeps `bytes` has to give up samples when all channels together keep
  /// `more_bytes` more than now. A channel must not keep more than the unused rest of the limit. So a single
  /// channel can keep half of the limit. Several channels that keep much memory approach equal shares of the
  /// limit, and an equal share stays unused for channels that keep little.
  bool wants_some_of(std::size_t bytes, std::size_t more_bytes = 0) const {
    const std::size_t used = this->used() + more_bytes;
    return used > limit_ || bytes > limit_ - used;
  }

 private:
  const std::size_t limit_;
  std::atomic<std::size_t> used_{0};
};

}  // namespace sft::udp
