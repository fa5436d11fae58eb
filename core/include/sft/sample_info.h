// The origin of a received sample: its number, publisher, stamps and path.
#pragma once

#include <chrono>
#include <cstdint>

#include "sft/status.h"

namespace sft {

/// A part of each sample, as old as the sample. Stamps are in UTC, as std::chrono::system_clock counts.
struct SampleInfo {
  std::uint64_t sequence = 0;  ///< number of the sample among those of its publisher, from 1
  std::uint64_t writer = 0;    ///< id of the publisher
  std::chrono::sys_time<std::chrono::nanoseconds> source_stamp{};  ///< at publish, by the publisher's clock
  /// When the sample was complete on this host. A sample in shared memory is complete when it is published;
  /// its stamp tells when it was taken.
  std::chrono::sys_time<std::chrono::nanoseconds> receive_stamp{};
  std::uint64_t lost_before = 0;  ///< samples of this publisher since the one before by the same selection
  TransportKind transport{};      ///< the path by which the sample came
  /// The selection that it came by: 0, or 1 for the first of SubscriberOptions::further_selections, and so
  /// on.
  std::uint32_t selection = 0;
};

}  // namespace sft
