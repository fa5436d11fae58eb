// Automatic requirement recording (ARR): which leaves a subscriber's getters read, folded sample by sample
// into what it asks its publishers for. Widening is immediate, at the first read of a leaf that is not asked
// for; narrowing waits until a leaf was not read for a number of samples.
//
// Samples are numbered as they are released. All functions can be called by any thread; what a sample costs
// depends on the leaves that were read in it, and in steady state nothing is allocated.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/subscribe/read_order.h"
#include "core/sync/guarded_call.h"
#include "core/sync/mutex.h"
#include "sft/detail/access_log.h"
#include "sft/mask.h"
#include "sft/options.h"
#include "sft/result.h"

namespace sft::core {

class Recorder;

/// The accesses of one sample that is being read. Belongs to its recorder, which lives as long as any is out.
class RecordedSample {
 public:
  RecordedSample(std::size_t words, detail::AccessLog::Listener* listener)
      : words_(words), log_(words_, listener) {}
  detail::AccessLog& log() { return log_; }

 private:
  friend class Recorder;
  std::vector<detail::AccessWord> words_;
  detail::AccessLog log_;
  std::shared_ptr<Recorder> recorder_;  ///< while it is out
  RecordedSample* next_free_ = nullptr;
};

class Recorder final : public std::enable_shared_from_this<Recorder>, private detail::AccessLog::Listener {
 public:
  /// Told that required() has changed, on the thread of a getter or of whoever released a sample, with no
  /// lock held. It posts, and returns. Since required() is asked for then, it does not matter in which order
  /// two threads tell.
  using Changed = GuardedCall<>::Function;

  static Result<void> check(const SubscriberOptions::Recording& settings);
  /// `settings` have been checked.
  static std::shared_ptr<Recorder> make(std::size_t leaves, const SubscriberOptions::Recording& settings,
                                        Changed changed);

  /// When it returns, nobody is being told of changes, nor will be. Samples may outlive whoever was told.
  void detach() { changed_.clear(); }

  RecordedSample* begin();
  /// Folds the accesses of a sample.
  static void end(RecordedSample* sample) noexcept;

  /// The leaves that are needed, as far as is known: all of them until the first samples were read.
  FieldMask required() const;

  struct LeafUse {
    std::uint64_t samples = 0;      ///< in so many it was read
    std::uint64_t last_sample = 0;  ///< the number of the last of them, from 1; 0: none
  };
  struct Use {
    std::uint64_t samples = 0;  ///< released so far
    std::vector<LeafUse> leaves;
  };
  Use use() const;

 private:
  struct Leaf {
    LeafUse use;
    std::uint64_t needed_since = 0;  ///< the newest sample that was seen to need it
  };

  Recorder(std::size_t leaves, const SubscriberOptions::Recording& settings, Changed changed);
  RecordedSample* add();
  void first_read(std::size_t leaf) noexcept override;
  void fold(RecordedSample& sample) noexcept;
  // These return true if required_ has changed.
  bool count(RecordedSample& sample) noexcept SFT_REQUIRES(mutex_);
  bool need(std::size_t leaf, std::uint64_t sample) noexcept SFT_REQUIRES(mutex_);
  bool give_up_stale() noexcept SFT_REQUIRES(mutex_);
  bool finish_learning() noexcept SFT_REQUIRES(mutex_);
  bool is_required(std::size_t leaf) const noexcept;

  const std::size_t leaf_count_;
  const SubscriberOptions::Recording settings_;
  GuardedCall<> changed_;

  mutable Mutex mutex_;  // held for a few instructions
  /// Changed with the mutex held; getters look without it.
  std::vector<std::atomic<std::uint64_t>> required_;
  std::vector<Leaf> leaves_ SFT_GUARDED_BY(mutex_);
  ReadOrder order_ SFT_GUARDED_BY(mutex_);  ///< of the leaves that are needed, by needed_since
  std::uint64_t samples_ SFT_GUARDED_BY(mutex_) = 0;
  std::vector<std::unique_ptr<RecordedSample>> owned_ SFT_GUARDED_BY(mutex_);
  RecordedSample* free_ SFT_GUARDED_BY(mutex_) = nullptr;
};

}  // namespace sft::core
