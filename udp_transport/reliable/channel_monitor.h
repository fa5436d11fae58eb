// Decides which channel of a writer a reader's process follows. One wrong channel number, as by a flipped
// bit, must not make it ignore the channel that the writer uses. Uses no clock, thread or I/O.
//
// A channel that begins is followed at once. A channel that was followed before, or whose ordinals are too
// high for a beginning, is followed only after several datagrams. Single datagrams of a former channel may
// only be late.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "udp_transport/wire/datagram.h"

namespace sft::udp {

class ChannelMonitor {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// A channel whose datagram has an ordinal of at most this value counts as a channel that begins.
  static constexpr std::uint64_t beginning_max = 64;
  /// The number of different ordinals in a row after which a former channel is followed again. Datagrams
  /// with the same ordinal do not count, because a large sample of a former channel may still be under way
  /// in many datagrams.
  static constexpr std::uint32_t in_a_row = 64;
  /// Another channel is followed after only two datagrams if they came at least this time apart, and no
  /// datagram of the present channel came between them.
  static constexpr std::chrono::milliseconds present_unconfirmed_after{250};
  /// If the number of another channel has the same low bits as the present one, this number of datagrams is
  /// needed, and the present channel must have been silent for `present_unconfirmed_after`. Whole datagrams
  /// carry only the low bits, so the reader would assign datagrams of the right channel to a wrong one.
  static constexpr std::uint32_t alike_in_a_row = 4;

  /// This number of datagrams of a former channel, after that silence, shows that the channel was followed
  /// too far. Their ordinals are less than the next ordinal at the time when the channel was left.
  static constexpr std::uint32_t behind_in_a_row = 4;

  /// The numbers in a datagram. `first` and `last` are both the ordinal of a sample, or the range of
  /// ordinals in a heartbeat.
  struct Observed {
    std::uint32_t channel = 0;
    std::uint64_t first = 0;
    std::uint64_t last = 0;
    bool same_datagram = false;  ///< true if the previous observation is from the same datagram
  };
  enum class Verdict : std::uint8_t {
    present,  ///< the datagram belongs to the channel that is followed
    turn,     ///< the datagram's channel has to be followed from now on; the caller calls turn()
    ignore,
  };
  Verdict evaluate(const Observed& observed, Time now);
  /// Follows that channel from now on. `next` is the next ordinal of the channel that was followed until
  /// now. Returns the next ordinal of the new channel: 1, or for a former channel its next ordinal when it
  /// was left.
  std::uint64_t turn(std::uint32_t channel, std::uint64_t next);

  const std::optional<std::uint32_t>& present() const { return present_; }
  /// Returns the channel number that is `low` modulo `end`, a power of two. The result is a known channel,
  /// or otherwise the number nearest to the present channel's number. It is empty if no channel is known
  /// yet.
  std::optional<std::uint32_t> widen(std::uint32_t low, std::uint32_t end) const;

 private:
  struct Former {
    std::uint32_t channel = 0;
    std::uint64_t next = 0;
  };
  static constexpr std::size_t former_max = 8;
  /// Channel numbers count up. So a number that is less than the present one by at most this difference
  /// belongs to a former channel, too.
  static constexpr std::uint32_t just_before = 64;

  const Former* former(std::uint32_t channel) const;
  bool precedes(std::uint32_t channel) const { return *present_ - channel <= just_before; }
  bool is_like_present(std::uint32_t channel) const {
    return channel % whole_channels_end == *present_ % whole_channels_end;
  }

  std::optional<std::uint32_t> present_;
  Time heard_at_{};
  std::vector<Former> former_;     ///< former channels; the newest is last
  std::uint32_t unconfirmed_ = 0;  ///< number of another channel that may have to be followed
  /// The number of datagrams of that channel since the last datagram of the present channel.
  std::uint32_t observations_ = 0;
  Time unconfirmed_since_{};             ///< time when the first of these datagrams came
  std::uint32_t ordinals_observed_ = 0;  ///< number of consecutive ordinals in these datagrams
  std::uint64_t last_observed_ = 0;
};

}  // namespace sft::udp
