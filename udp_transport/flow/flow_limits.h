// Limits of what is sent to one remote socket (FlowWindow).
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>

namespace sft::udp {

struct FlowLimits {
  bool asks = true;  ///< false: nobody is asked to report, or waited for: a multicast group
  std::uint64_t unheard_bytes_per_s = 600'000'000;  ///< that pass where nobody is asked
  std::uint64_t unasked_bytes_per_s = 1'000'000;    ///< that receivers take, as we believe without a report;
                                                    ///< here datagrams count as long as they are
  // These limits hold for a receiver that has not reported yet.
  std::size_t unproven_bytes = 24'000;
  std::size_t unproven_datagrams = 16;
  std::size_t unproven_marks = 8;                  ///< more of them count as datagrams to the host
  std::size_t first_bytes = std::size_t{1} << 20;  ///< under way, before anything is known of the way
  std::size_t least_bytes = 32 * 1024;             ///< under way, however bad it is
  std::size_t mark_spacing_min = 24 * 1024;
  std::size_t mark_spacing_max = 3072 * 1024;
  std::chrono::milliseconds queueing{4};    ///< more than the shortest time there and back
  std::chrono::milliseconds mark_again{2};  ///< after twice the time there and back, but not before
  std::chrono::milliseconds mark_again_unheard{10};
  std::chrono::milliseconds mark_again_longest{50};
  std::chrono::milliseconds mark_anew{2000};  ///< after the last report, if anything is sent
  /// The same where acks come. A slow reliable flow has one every 4 s (ResendLimits::heartbeat_period), which
  /// does what a mark would.
  std::chrono::milliseconds mark_anew_behind_acks{4500};
  std::chrono::milliseconds silence{1000};  ///< after which nothing but marks is sent
  // Between two marks to a receiver that is silent, or has never reported: longer the longer it lasts, but it
  // is served again soon after it has come back.
  std::chrono::milliseconds mark_silent{250};
  std::chrono::milliseconds mark_silent_longest{750};
  std::chrono::milliseconds mark_unproven_longest{2000};
};

}  // namespace sft::udp
