// Decides which channel of a writer counts. One wrong channel number must not keep a reader from the
// channel that the writer uses. Pure: numbers and times in, answers out.
//
// A channel that begins is followed at once. A channel that was followed before, or whose numbers do not look
// like a beginning, needs several datagrams: those of a former channel may only be late.
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
  /// After so many ordinals in a row a former channel is followed again. (One large sample of it may still be
  /// under way in many datagrams.)
  static constexpr std::uint32_t in_a_row = 64;
  /// Two are enough if they are so far apart and nothing of the present channel came between them.
  static constexpr std::chrono::milliseconds present_unconfirmed_after{250};
  /// A channel whose low bits are those of the present one needs that silence, too, and so many datagrams:
  /// whole datagrams have only low bits, so the reader would take the true channel's for those of a wrong
  /// one.
  static constexpr std::uint32_t alike_in_a_row = 4;

  /// After so many datagrams of a former channel, with that silence, which are behind the position where it
  /// was left, that position was not true either.
  static constexpr std::uint32_t behind_in_a_row = 4;

  /// A datagram's claim: the ordinal of a sample twice, or the range of a heartbeat.
  struct Observed {
    std::uint32_t channel = 0;
    std::uint64_t first = 0;
    std::uint64_t last = 0;
    bool same_datagram = false;  ///< as the claim before
  };
  enum class Verdict : std::uint8_t {
    present,  ///< of the channel that is followed
    turn,     ///< that channel is to be followed from now on: call turn()
    ignore,
  };
  Verdict evaluate(const Observed& observed, Time now);
  /// Follows that channel. `next` is the ordinal that the one before would have gone on with. Returns the
  /// ordinal that the new one goes on with: 1, but of a former channel where it was left.
  std::uint64_t turn(std::uint32_t channel, std::uint64_t next);

  const std::optional<std::uint32_t>& present() const { return present_; }
  /// The number that is `low` modulo `end`, a power of two: of a channel that is known, or else the nearest
  /// to the present one. Empty while no channel is known.
  std::optional<std::uint32_t> widen(std::uint32_t low, std::uint32_t end) const;

 private:
  struct Former {
    std::uint32_t channel = 0;
    std::uint64_t next = 0;
  };
  static constexpr std::size_t former_max = 8;
  /// Channels are counted up: numbers so close below the present one are former ones, too.
  static constexpr std::uint32_t just_before = 64;

  const Former* former(std::uint32_t channel) const;
  bool precedes(std::uint32_t channel) const { return *present_ - channel <= just_before; }
  bool is_like_present(std::uint32_t channel) const {
    return channel % whole_channels_end == *present_ % whole_channels_end;
  }

  std::optional<std::uint32_t> present_;
  Time heard_at_{};
  std::vector<Former> former_;           ///< the newest last
  std::uint32_t unconfirmed_ = 0;        ///< a channel that may have to be followed
  std::uint32_t observations_ = 0;       ///< datagrams of it since the present one was heard
  Time unconfirmed_since_{};             ///< when the first of these came
  std::uint32_t ordinals_observed_ = 0;  ///< different ones in a row, in these
  std::uint64_t last_observed_ = 0;
};

}  // namespace sft::udp
