// The origin of a received sample: its number, publisher, stamps and path.
#pragma once

#include <chrono>
#include <cstdint>

#include "sft/status.h"

namespace sft {

/// The origin of a sample. The object belongs to the sample, and is valid as long as the sample. Stamps are
/// in UTC, as std::chrono::system_clock counts.
struct SampleInfo {
  std::uint64_t sequence = 0;  ///< the number of the sample among all samples of its publisher, from 1
  std::uint64_t writer = 0;    ///< the id of the publisher
  /// The time of publish(), by the publisher's clock.
  std::chrono::sys_time<std::chrono::nanoseconds> source_stamp{};
  /// The time at which the sample was complete on this host. A sample in shared memory is complete when it
  /// is published; for such a sample this is the time of take().
  std::chrono::sys_time<std::chrono::nanoseconds> receive_stamp{};
  /// The number of samples of this publisher that were lost between the previous sample of the same selection
  /// and this one.
  std::uint64_t lost_before = 0;
  TransportKind transport{};  ///< the path by which the sample arrived
  /// The number of the selection for which the sample was sent: 0 for the first selection, 1 for the first
  /// element of SubscriberOptions::further_selections, and so on.
  std::uint32_t selection = 0;
};

}  // namespace sft
