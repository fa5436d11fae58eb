// The last samples of a publisher, kept for readers that come later.
#pragma once

#include <cstdint>
#include <vector>

#include "core/seam/sample_buffer.h"
#include "core/sync/mutex.h"

namespace sft::core {

class History {
 public:
  /// Samples older than `lifespan_ns` are let go of; 0: none is too old.
  History(std::uint32_t depth, std::int64_t lifespan_ns);

  /// Keeps a sample whose sequence and stamp are set, and lets go of the oldest beyond the depth.
  void add(const SampleHandle& sample);
  /// Keeps this one for the one with its sequence, if that is still kept.
  void replace(const SampleHandle& sample);
  /// At most the last `count`, the oldest first.
  std::vector<SampleHandle> last(std::size_t count, std::int64_t now_ns) const;
  void expire(std::int64_t now_ns);

 private:
  bool is_expired(const SampleHandle& sample, std::int64_t now_ns) const;

  const std::int64_t lifespan_ns_;
  mutable Mutex mutex_;  // held for a few instructions; samples are let go of outside
  std::vector<SampleHandle> samples_ SFT_GUARDED_BY(mutex_);  ///< a ring, empty handles where nothing is kept
  std::size_t next_ SFT_GUARDED_BY(mutex_) = 0;  ///< place of the next sample, which is that of the oldest
};

}  // namespace sft::core
