// The log of the leaves that getters of one recorded sample read, one bit per leaf. Reads of the points of
// clouds are noted channel by channel: each channel has a bit and a number, which is greater than the
// numbers of all leaves. Any number of threads may read the sample.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "sft/selection.h"

namespace sft::detail {

/// The difference between a sample with only some channels of its clouds and the published sample.
struct ChannelsSent {
  Selection selection;  ///< its parts have the channels that were sent
  FieldMask changed;    ///< fields whose values differ: the points, and the fields that describe them
};

/// The bits of 64 leaves that were read. There are two words, so that a getter needs only the bit in
/// `found` to know that the read was noted before and that the sample has the leaf.
struct AccessWord {
  std::atomic<std::uint64_t> found{0};   ///< leaves that were read and that the sample has
  std::atomic<std::uint64_t> missed{0};  ///< leaves that were read and that the sample lacks
};

class AccessLog {
 public:
  class Listener {
   public:
    /// Called at the first access to a leaf of this sample, on the reading thread. The function must not
    /// block.
    virtual void first_read(std::size_t leaf) noexcept = 0;
    /// Returns the number of a channel of the cloud that has its points in this leaf. The number is the
    /// same in all samples. Returns nothing if the channels of that leaf are not noted one by one, or are
    /// no longer noted one by one.
    virtual std::optional<std::size_t> number_of_channel(std::size_t /*leaf*/,
                                                         std::string_view /*name*/) noexcept {
      return {};
    }

   protected:
    ~Listener() = default;
  };

  /// `words` must have a bit for each leaf and channel, be zero at first, and outlive the log. `listener`
  /// may be null.
  AccessLog(std::span<AccessWord> words, Listener* listener) : words_(words.data()), listener_(listener) {}

  /// Returns true if the leaf was read before and the sample has it.
  bool has_found(std::size_t leaf) const noexcept {
    return (words_[leaf / 64].found.load(std::memory_order_relaxed) & bit(leaf)) != 0;
  }

  /// Notes an access. `present` is true if the sample has the leaf, and is the same at each call for a
  /// leaf.
  void touch(std::size_t leaf, bool present) noexcept {
    AccessWord& word = words_[leaf / 64];
    std::atomic<std::uint64_t>& read = present ? word.found : word.missed;
    if ((read.load(std::memory_order_relaxed) & bit(leaf)) != 0) return;
    const bool first = (read.fetch_or(bit(leaf), std::memory_order_relaxed) & bit(leaf)) == 0;
    if (first && listener_ != nullptr) listener_->first_read(leaf);
  }

  /// Sets which channels of its clouds the sample has. Null, the initial value, means all channels. `sent`
  /// must outlive the use of the log.
  void set_channels_sent(const ChannelsSent* sent) noexcept { sent_ = sent; }
  /// Returns false if the value of any of these leaves in the sample differs from the value in the
  /// published message. A getter of such a field behaves as if the field was not sent.
  bool is_as_published(std::size_t leaf, std::size_t leaves) const noexcept {
    return sent_ == nullptr || !sent_->changed.any_of(leaf, leaves);
  }
  /// Notes a read of a channel of the cloud that has its points in this leaf. Returns whether the sample
  /// was sent with the channel. `present` is true if the sample has the leaf, at least a part of it. If
  /// channels of that leaf are not noted one by one, notes nothing and returns nothing.
  std::optional<bool> touch_channel(std::size_t leaf, std::string_view name, bool present) noexcept;

 private:
  static constexpr std::uint64_t bit(std::size_t leaf) { return std::uint64_t{1} << (leaf % 64); }

  AccessWord* words_;
  Listener* listener_;
  const ChannelsSent* sent_ = nullptr;
};

}  // namespace sft::detail
