// Clears the pages of the daemon's segments while the daemon serves already. A page of a new file is cleared
// when somebody uses it for the first time. Without this the first samples of each size would wait for that.
#pragma once

#include <atomic>
#include <thread>
#include <vector>

#include "sft/result.h"
#include "shm_transport/sftd/segment_file.h"

namespace sft::shm {

/// A thread that yields to all others. It changes no byte, so programs may use the memory meanwhile.
class PageClearer {
 public:
  /// The segments are cleared in this order, except what has memory only on demand. An error if the system
  /// gives no thread; then pages are cleared when they are used.
  Result<void> start(std::vector<SegmentFile> segments);

  PageClearer() = default;
  /// Stops in a moment, wherever it is.
  ~PageClearer();
  PageClearer(const PageClearer&) = delete;
  PageClearer& operator=(const PageClearer&) = delete;

 private:
  void clear() const;

  std::vector<SegmentFile> segments_;
  std::atomic<bool> stops_{false};
  std::thread thread_;
};

}  // namespace sft::shm
