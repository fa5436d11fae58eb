// Clears the pages of the daemon's segments while the daemon already serves programs. Otherwise the system
// would clear a page of a new file when the page is used for the first time, and the first samples of each
// size would wait for that.
#pragma once

#include <atomic>
#include <thread>
#include <vector>

#include "sft/result.h"
#include "shm_transport/sftd/segment_file.h"

namespace sft::shm {

/// A thread with low priority. It changes no byte, so programs may use the memory meanwhile.
class PageClearer {
 public:
  /// Starts to clear the segments in this order, except the parts that have memory only on demand. Returns
  /// an error if the system gives no thread. In that case pages are cleared when they are used.
  Result<void> start(std::vector<SegmentFile> segments);

  PageClearer() = default;
  /// Stops the thread, even if it has not cleared all pages.
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
