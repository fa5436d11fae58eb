// The last samples of a publisher, kept for readers that join later.
#pragma once

#include <cstdint>
#include <vector>

#include "core/seam/sample_buffer.h"
#include "core/sync/mutex.h"

namespace sft::core {

class History {
 public:
  /// Samples that are older than `lifespan_ns` are dropped. 0: samples never expire.
  History(std::uint32_t depth, std::int64_t lifespan_ns);

  /// Keeps a sample whose sequence and stamp are set, and drops the oldest sample if there are more than
  /// `depth` samples.
  void add(const SampleHandle& sample);
  /// Replaces the kept sample with the same sequence by `sample`. Does nothing if no kept sample has this
  /// sequence.
  void replace(const SampleHandle& sample);
  /// Returns at most the last `count` samples that have not expired, the oldest first.
  std::vector<SampleHandle> last(std::size_t count, std::int64_t now_ns) const;
  void expire(std::int64_t now_ns);

 private:
  bool is_expired(const SampleHandle& sample, std::int64_t now_ns) const;

  const std::int64_t lifespan_ns_;
  mutable Mutex mutex_;  // held for a few instructions; samples are released after it is unlocked
  std::vector<SampleHandle> samples_ SFT_GUARDED_BY(mutex_);  ///< a ring; unused elements are empty handles
  /// The index for the next sample. If the ring is full, it is the index of the oldest sample.
  std::size_t next_ SFT_GUARDED_BY(mutex_) = 0;
};

}  // namespace sft::core
