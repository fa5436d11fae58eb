// Automatic requirement recording (ARR). It records which leaves the getters of a subscriber read. From this
// it derives, sample by sample, the fields that the subscriber requests from its publishers. A leaf is
// requested immediately when it is first read. The request ends only when the leaf was not read in a number
// of samples. A channel of a cloud is recorded like a leaf (channel_numbers.h).
//
// Samples are numbered in the order in which they are released. All functions can be called by any thread.
// The cost of a sample depends on the leaves that were read in it, and in steady state nothing is allocated.
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

/// The accesses to one sample that is being read. The object belongs to its recorder, which lives as long as
/// any such object is in use.
class RecordedSample {
 public:
  RecordedSample(std::size_t words, detail::AccessLog::Listener* listener)
      : words_(words), log_(words_, listener) {}
  detail::AccessLog& log() { return log_; }
  /// Called if the sample has only the channels `sent` of its clouds.
  void set_channels_sent(std::shared_ptr<const detail::ChannelsSent> sent) {
    log_.set_channels_sent(sent.get());
    sent_ = std::move(sent);
  }

 private:
  friend class Recorder;
  std::vector<detail::AccessWord> words_;
  detail::AccessLog log_;
  std::shared_ptr<const detail::ChannelsSent> sent_;
  std::shared_ptr<Recorder> recorder_;  ///< set while this object is in use
  RecordedSample* next_free_ = nullptr;
};

class Recorder final : public std::enable_shared_from_this<Recorder>, private detail::AccessLog::Listener {
 public:
  /// Called when required() has changed, by a thread that called a getter or released a sample, with no lock
  /// held. The function posts a task, and returns. Since required() is read later, the order of two calls on
  /// different threads does not matter.
  using Changed = GuardedCall<>::Function;

  static Result<void> check(const SubscriberOptions::Recording& settings);
  /// `settings` must have been checked. `clouds` are the clouds whose channels are recorded.
  static std::shared_ptr<Recorder> make(std::size_t leaves, const SubscriberOptions::Recording& settings,
                                        Changed changed, std::vector<ChannelNumbers::Cloud> clouds = {});

  /// Ends the calls of `changed`. When detach() returns, `changed` is not running and will not be called any
  /// more. This is necessary because samples may outlive the objects that `changed` uses.
  void detach() { changed_.clear(); }

  RecordedSample* begin();
  /// Evaluates the accesses to a sample when it is released.
  static void end(RecordedSample* sample) noexcept;

  /// Returns the fields and channels that are needed, as far as is known. Until the first samples were read,
  /// these are all fields.
  Selection required() const;
  /// Returns true if the type has clouds whose channels are recorded.
  bool records_channels() const { return channels_.has_clouds(); }
  /// Describes the difference between samples of that selection and the published messages. Returns nothing
  /// if they do not differ.
  std::optional<detail::ChannelsSent> sent_for(const Selection& selection) const {
    return channels_.sent_for(selection);
  }

  struct LeafUse {
    std::uint64_t samples = 0;  ///< the number of samples in which the leaf was read
    /// The number of the last of these samples, from 1; 0: the leaf was never read.
    std::uint64_t last_sample = 0;
  };
  struct Use {
    std::uint64_t samples = 0;  ///< the number of samples released so far
    std::vector<LeafUse> leaves;
    Selection read;  ///< the fields and channels that were read in at least one sample
  };
  Use use() const;

 private:
  struct Leaf {
    LeafUse use;
    std::uint64_t needed_since = 0;  ///< the number of the newest sample in which the leaf was needed
    bool was_read = false;           ///< true: the leaf itself was read, and not only channels of it
  };

  Recorder(std::size_t leaves, const SubscriberOptions::Recording& settings, Changed changed,
           std::vector<ChannelNumbers::Cloud> clouds);
  RecordedSample* add();
  void first_read(std::size_t leaf) noexcept override;
  std::optional<std::size_t> number_of_channel(std::size_t leaf, std::string_view name) noexcept override {
    return channels_.number_of(leaf, name);
  }
  void fold(RecordedSample& sample) noexcept;
  // These functions return true if required_ has changed.
  bool count(RecordedSample& sample) noexcept SFT_REQUIRES(mutex_);
  void count_use(std::size_t leaf) noexcept SFT_REQUIRES(mutex_);
  bool need(std::size_t leaf, std::uint64_t sample) noexcept SFT_REQUIRES(mutex_);
  bool give_up_stale() noexcept SFT_REQUIRES(mutex_);
  bool finish_learning() noexcept SFT_REQUIRES(mutex_);
  bool is_required(std::size_t leaf) const noexcept;

  // Leaves and channels have numbers from one range, and both are called leaves below.
  const std::size_t leaf_count_;  ///< the number of leaves without channels
  const SubscriberOptions::Recording settings_;
  ChannelNumbers channels_;
  GuardedCall<> changed_;

  mutable Mutex mutex_;  // held for a few instructions
  /// Changed with the mutex held; getters read it without the mutex.
  std::vector<std::atomic<std::uint64_t>> required_;
  std::vector<Leaf> leaves_ SFT_GUARDED_BY(mutex_);
  ReadOrder order_ SFT_GUARDED_BY(mutex_);  ///< the needed leaves in the order of needed_since
  std::uint64_t samples_ SFT_GUARDED_BY(mutex_) = 0;
  std::vector<std::unique_ptr<RecordedSample>> owned_ SFT_GUARDED_BY(mutex_);
  RecordedSample* free_ SFT_GUARDED_BY(mutex_) = nullptr;
};

}  // namespace sft::core
