// Decides which channel of a writer counts. One wrong channel number must not keep a reader from the
// channel that the writer uses. Uses no clock, thread or I/O.
//
// A channel that begins is followed at once. A channel that was followed before, or whose ordinals do not
// look like a beginning, needs several datagrams, because those of a former channel may only be late.
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

  /// A channel whose ordinals are not above this looks like one that begins.
  static constexpr std::uint64_t beginning_max = 64;
  /// After this many ordinals in a row a former channel is followed again. (One large sample of it may
  /// still be under way in many datagrams.)
  static constexpr std::uint32_t in_a_row = 64;
  /// Two datagrams are enough if they are this far apart and none of the present channel came between them.
  static constexpr std::chrono::milliseconds present_unconfirmed_after{250};
  /// A channel with the same low bits as the present one needs that silence and this many datagrams. Whole
  /// datagrams have only low bits, so the reader would take those of the true channel for those of a wrong
  /// one.
  static constexpr std::uint32_t alike_in_a_row = 4;

  /// If this many datagrams of a former channel, after that silence, are behind the position where it was
  /// left, it had been followed too far.
  static constexpr std::uint32_t behind_in_a_row = 4;

  /// What a datagram says: the ordinal of a sample as both `first` and `last`, or the range of a heartbeat.
  struct Observed {
    std::uint32_t channel = 0;
    std::uint64_t first = 0;
    std::uint64_t last = 0;
    bool same_datagram = false;  ///< the previous claim came in the same datagram
  };
  enum class Verdict : std::uint8_t {
    present,  ///< the claim is about the channel that is followed
    turn,     ///< that channel is to be followed from now on; the caller calls turn()
    ignore,
  };
  Verdict evaluate(const Observed& observed, Time now);
  /// Follows that channel. `next` is the next ordinal of the channel that is left. Returns the next ordinal
  /// of the new channel: 1, or for a former channel the one where it was left.
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
  /// Channel numbers count up. Numbers that are this close below the present one belong to former channels,
  /// too.
  static constexpr std::uint32_t just_before = 64;

  const Former* former(std::uint32_t channel) const;
  bool precedes(std::uint32_t channel) const { return *present_ - channel <= just_before; }
  bool is_like_present(std::uint32_t channel) const {
    return channel % whole_channels_end == *present_ % whole_channels_end;
  }

  std::optional<std::uint32_t> present_;
  Time heard_at_{};
  std::vector<Former> former_;           ///< former channels; the newest is last
  std::uint32_t unconfirmed_ = 0;        ///< number of another channel that may have to be followed
  std::uint32_t observations_ = 0;       ///< number of its datagrams since the present channel was heard
  Time unconfirmed_since_{};             ///< when the first of these datagrams came
  std::uint32_t ordinals_observed_ = 0;  ///< number of different ordinals in a row, in these datagrams
  std::uint64_t last_observed_ = 0;
};

}  // namespace sft::udp
