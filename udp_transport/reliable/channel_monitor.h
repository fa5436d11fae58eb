// Decides which channel of a writer counts. One wrong channel number must not keep a reader from the
// channel that the writer uses. Uses no clock, thread or I/O.
//
// A channel that begins is followed at once. A channel that was followed before, or whose ordinals do not
// look like a beginning, needs several datagrams, because single datagrams of a former channel may only be
// late.
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

  /// A channel with ordinals up to this one looks like a channel that begins.
  static constexpr std::uint64_t beginning_max = 64;
  /// The number of ordinals in a row after which a former channel is followed again. (One large sample of
  /// it may still be under way in many datagrams, which have one ordinal.)
  static constexpr std::uint32_t in_a_row = 64;
  /// Two datagrams of another channel are enough if they are this far apart and no datagram of the present
  /// channel came between them.
  static constexpr std::chrono::milliseconds present_unconfirmed_after{250};
  /// A channel whose number has the same low bits as the present one needs that silence and this many
  /// datagrams. Whole datagrams have only low bits, so the reader would assign datagrams of the right
  /// channel to a wrong one.
  static constexpr std::uint32_t alike_in_a_row = 4;

  /// The number of datagrams of a former channel which, after that silence, show that the channel was
  /// followed too far: their ordinals are before the one where it was left.
  static constexpr std::uint32_t behind_in_a_row = 4;

  /// The content of a datagram: the ordinal of a sample as both `first` and `last`, or the range of a
  /// heartbeat.
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
  /// Follows that channel. `next` is the next ordinal of the channel that is left. Returns the next ordinal
  /// of the new channel. It is 1, or for a former channel the ordinal where it was left.
  std::uint64_t turn(std::uint32_t channel, std::uint64_t next);

  const std::optional<std::uint32_t>& present() const { return present_; }
  /// Returns the channel number that is `low` modulo `end`, a power of two. This is a known channel, or
  /// else the number nearest to the present one. Empty while no channel is known.
  std::optional<std::uint32_t> widen(std::uint32_t low, std::uint32_t end) const;

 private:
  struct Former {
    std::uint32_t channel = 0;
    std::uint64_t next = 0;
  };
  static constexpr std::size_t former_max = 8;
  /// Channel numbers count up. So numbers below the present one, by this much at most, belong to former
  /// channels, too.
  static constexpr std::uint32_t just_before = 64;

  const Former* former(std::uint32_t channel) const;
  bool precedes(std::uint32_t channel) const { return *present_ - channel <= just_before; }
  bool is_like_present(std::uint32_t channel) const {
    return channel % whole_channels_end == *present_ % whole_channels_end;
  }

  std::optional<std::uint32_t> present_;
  Time heard_at_{};
  std::vector<Former> former_;     ///< former channels; the newest is last
  std::uint32_t unconfirmed_ = 0;  ///< number of another channel, which may be the right one
  /// Number of datagrams of that channel since the last one of the present channel.
  std::uint32_t observations_ = 0;
  Time unconfirmed_since_{};             ///< time when the first of these datagrams came
  std::uint32_t ordinals_observed_ = 0;  ///< number of consecutive ordinals in these datagrams
  std::uint64_t last_observed_ = 0;
};

}  // namespace sft::udp
