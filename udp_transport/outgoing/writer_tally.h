// The counts of the samples that one writer has sent and lost, and the limit of its rate in bytes per
// second.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

#include "udp_transport/flow/rate_limit.h"
#include "udp_transport/outgoing/resend_limits.h"

namespace sft::udp {

/// Counts and limits of one writer, over all its lanes.
struct WriterTally {
  explicit WriterTally(std::uint64_t max_bytes_per_s = 0, std::int8_t writer_priority = 0,
                       const ResendLimits& resend_limits = {})
      : limit(max_bytes_per_s), priority(writer_priority), resend(resend_limits) {}
  RateLimit limit;
  const std::int8_t priority;  ///< large samples of the writer with the greatest number are sent first
  /// The limits of each channel, and of the reliable samples that wait for the sending thread.
  const ResendLimits resend;
  std::atomic<std::uint64_t> bytes_sent{0};
  std::atomic<std::uint64_t> dropped{0};  ///< number of samples that were taken from a lane and then not sent
  /// The number of lanes with data for the sending thread to send, including lanes that get no new samples
  /// any more.
  std::atomic<std::uint32_t> busy_lanes{0};
  /// The number of these lanes whose samples may be for readers with different masks (LaneEnd::is_merged()).
  std::atomic<std::uint32_t> busy_merged_lanes{0};
};

}  // namespace sft::udp
