// Clears the pages of the daemon's segments while the daemon serves already. A page of a new file is cleared
// when somebody uses it for the first time. Without this the first samples of each size would wait for that.
#pragma once

#include <atomic>
#include <cstddef>
#include <span>
#include <thread>
#include <vector>

#include "sft/result.h"

namespace sft::shm {

/// A thread that yields to all others. It changes no byte, so programs may use the memory meanwhile.
class PageClearer {
 public:
  /// `memory`: shared mappings, which are cleared in this order. They outlive this object. An error if the
  /// system gives no thread; then pages are cleared when they are used.
  Result<void> start(std::vector<std::span<const std::byte>> memory);

  PageClearer() = default;
  /// Stops in a moment, wherever it is.
  ~PageClearer();
  PageClearer(const PageClearer&) = delete;
  PageClearer& operator=(const PageClearer&) = delete;

 private:
  void clear(const std::vector<std::span<const std::byte>>& memory);

  std::atomic<bool> stops_{false};
  std::thread thread_;
};

}  // namespace sft::shm
