// Limits of the data that is sent to one remote socket (FlowWindow).
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>

namespace sft::udp {

struct FlowLimits {
  /// False: receivers are not asked to report, and senders wait for no report. This is for multicast groups.
  bool asks = true;
  /// The bytes per second that are assumed to pass if `asks` is false.
  std::uint64_t unheard_bytes_per_s = 600'000'000;
  /// The bytes per second that are assumed to pass without a report. In this rate a datagram counts with its
  /// length alone, without the kernel's overhead.
  std::uint64_t unasked_bytes_per_s = 1'000'000;
  // The following three maximums hold for a receiver that has not reported yet.
  std::size_t unproven_bytes = 24'000;
  std::size_t unproven_datagrams = 16;
  /// The maximum number of flow marks (requests for a report); further flow marks use up the host's budget
  /// (UnprovenBudget).
  std::size_t unproven_marks = 8;
  /// The size of the window before the first report, in bytes.
  std::size_t first_bytes = std::size_t{1} << 20;
  std::size_t least_bytes = 32 * 1024;  ///< the minimum size of the window in bytes, however bad the path is
  std::size_t mark_spacing_min = 24 * 1024;
  std::size_t mark_spacing_max = 3072 * 1024;
  /// The tolerated time in queues, in addition to the shortest round trip.
  std::chrono::milliseconds queueing{4};
  /// The minimum time before an unanswered flow mark is repeated; usually that time is two round trips.
  std::chrono::milliseconds mark_again{2};
  std::chrono::milliseconds mark_again_unheard{10};
  std::chrono::milliseconds mark_again_longest{50};
  /// The pause from the last report to the next flow mark if data is sent meanwhile.
  std::chrono::milliseconds mark_anew{2000};
  /// Replaces `mark_anew` if acks come. A slow reliable flow has an ack every 4 s
  /// (ResendLimits::heartbeat_period), which shows as well as a report that the receiver lives.
  std::chrono::milliseconds mark_anew_behind_acks{4500};
  std::chrono::milliseconds silence{1000};  ///< time without an answer after which only flow marks are sent
  // The pauses between two flow marks to a receiver that does not answer: the first pause, the longest pause
  // if the receiver has reported before, and the longest pause if it has never reported. All are short
  // enough that a receiver that has come back is soon served again.
  std::chrono::milliseconds mark_silent{250};
  std::chrono::milliseconds mark_silent_longest{750};
  std::chrono::milliseconds mark_unproven_longest{2000};
};

}  // namespace sft::udp
