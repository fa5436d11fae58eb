// Automatic requirement recording (ARR): which leaves a subscriber's getters read, folded sample by sample
// into what it asks its publishers for. Widening is immediate, at the first read of a leaf that is not asked
// for; narrowing waits until a leaf was not read for a number of samples. A channel of a cloud is recorded
// like a leaf (channel_numbers.h).
//
// Samples are numbered as they are released. All functions can be called by any thread; what a sample costs
// depends on the leaves that were read in it, and in steady state nothing is allocated.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "core/subscribe/channel_numbers.h"
#include "core/subscribe/read_order.h"
#include "core/sync/guarded_call.h"
#include "core/sync/mutex.h"
#include "sft/detail/access_log.h"
#include "sft/options.h"
#include "sft/result.h"
#include "sft/selection.h"

namespace sft::core {

class Recorder;

/// The accesses of one sample that is being read. Belongs to its recorder, which lives as long as any is out.
class RecordedSample {
 public:
  RecordedSample(std::size_t words, detail::AccessLog::Listener* listener)
      : words_(words), log_(words_, listener) {}
  detail::AccessLog& log() { return log_; }
  /// The sample has these channels of its clouds only.
  void set_channels_sent(std::shared_ptr<const detail::ChannelsSent> sent) {
    log_.set_channels_sent(sent.get());
    sent_ = std::move(sent);
  }

 private:
  friend class Recorder;
  std::vector<detail::AccessWord> words_;
  detail::AccessLog log_;
  std::shared_ptr<const detail::ChannelsSent> sent_;
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
  /// `settings` have been checked. `clouds`: those of which channels are recorded.
  static std::shared_ptr<Recorder> make(std::size_t leaves, const SubscriberOptions::Recording& settings,
                                        Changed changed, std::vector<ChannelNumbers::Cloud> clouds = {});

  /// When it returns, nobody is being told of changes, nor will be. Samples may outlive whoever was told.
  void detach() { changed_.clear(); }

  RecordedSample* begin();
  /// Folds the accesses of a sample.
  static void end(RecordedSample* sample) noexcept;

  /// The fields that are needed, and the channels, as far as is known: all fields until the first samples
  /// were read.
  Selection required() const;
  /// True if the type has clouds of which channels are recorded.
  bool records_channels() const { return channels_.has_clouds(); }
  /// Tells how samples differ from what was published if that selection is asked for. Nothing if they do not
  /// differ.
  std::optional<detail::ChannelsSent> sent_for(const Selection& selection) const {
    return channels_.sent_for(selection);
  }

  struct LeafUse {
    std::uint64_t samples = 0;      ///< in so many it was read
    std::uint64_t last_sample = 0;  ///< the number of the last of them, from 1; 0: none
  };
  struct Use {
    std::uint64_t samples = 0;  ///< released so far
    std::vector<LeafUse> leaves;
    Selection read;  ///< in at least one of them
  };
  Use use() const;

 private:
  struct Leaf {
    LeafUse use;
    std::uint64_t needed_since = 0;  ///< the newest sample that was seen to need it
    bool was_read = false;           ///< itself, and not only channels of it
  };

  Recorder(std::size_t leaves, const SubscriberOptions::Recording& settings, Changed changed,
           std::vector<ChannelNumbers::Cloud> clouds);
  RecordedSample* add();
  void first_read(std::size_t leaf) noexcept override;
  std::optional<std::size_t> number_of_channel(std::size_t leaf, std::string_view name) noexcept override {
    return channels_.number_of(leaf, name);
  }
  void fold(RecordedSample& sample) noexcept;
  // These return true if required_ has changed.
  bool count(RecordedSample& sample) noexcept SFT_REQUIRES(mutex_);
  void count_use(std::size_t leaf) noexcept SFT_REQUIRES(mutex_);
  bool need(std::size_t leaf, std::uint64_t sample) noexcept SFT_REQUIRES(mutex_);
  bool give_up_stale() noexcept SFT_REQUIRES(mutex_);
  bool finish_learning() noexcept SFT_REQUIRES(mutex_);
  bool is_required(std::size_t leaf) const noexcept;

  // Leaves and channels have numbers, which are called leaves here.
  const std::size_t leaf_count_;  ///< without channels
  const SubscriberOptions::Recording settings_;
  ChannelNumbers channels_;
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
