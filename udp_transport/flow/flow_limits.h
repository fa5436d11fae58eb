// Limits of what is sent to one remote socket (FlowWindow).
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>

namespace sft::udp {

struct FlowLimits {
  /// False: receivers are neither asked to report nor waited for, as for a multicast group.
  bool asks = true;
  /// Bytes per second assumed to pass if no receiver is asked.
  std::uint64_t unheard_bytes_per_s = 600'000'000;
  /// Bytes per second assumed to pass without a report. In this rate a datagram counts with its length
  /// alone.
  std::uint64_t unasked_bytes_per_s = 1'000'000;
  // These limits hold for a receiver that has not reported yet.
  std::size_t unproven_bytes = 24'000;
  std::size_t unproven_datagrams = 16;
  /// Number of marks; further ones are taken from the host's budget.
  std::size_t unproven_marks = 8;
  /// Window before anything is known about the path, in bytes.
  std::size_t first_bytes = std::size_t{1} << 20;
  std::size_t least_bytes = 32 * 1024;  ///< least window in bytes, however bad the path is
  std::size_t mark_spacing_min = 24 * 1024;
  std::size_t mark_spacing_max = 3072 * 1024;
  std::chrono::milliseconds queueing{4};  ///< queueing tolerated above the shortest round trip
  /// The least time before a mark is repeated; usually that time is two round trips.
  std::chrono::milliseconds mark_again{2};
  std::chrono::milliseconds mark_again_unheard{10};
  std::chrono::milliseconds mark_again_longest{50};
  /// Pause from the last report to the next mark, if anything is sent meanwhile.
  std::chrono::milliseconds mark_anew{2000};
  /// Replaces `mark_anew` if acks come. A slow reliable flow has an ack every 4 s
  /// (ResendLimits::heartbeat_period), which is as good as the answer to a mark.
  std::chrono::milliseconds mark_anew_behind_acks{4500};
  std::chrono::milliseconds silence{1000};  ///< time without an answer after which only marks are sent
  // The first pause between two marks to a receiver that is silent or has never reported. Later pauses are
  // longer, but short enough that a receiver that has come back is served again soon.
  std::chrono::milliseconds mark_silent{250};
  std::chrono::milliseconds mark_silent_longest{750};
  std::chrono::milliseconds mark_unproven_longest{2000};
};

}  // namespace sft::udp
