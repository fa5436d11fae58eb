// Divides destinations into divisions. Only destinations of one division may share a multicast group. Uses
// no clock, thread or I/O.
#pragma once

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "core/seam/route.h"

namespace sft::udp {

/// A destination that may be in a group.
struct DividedPlace {
  std::size_t link = 0;
  /// The union of the readers' requests, if conditions or a maximum rate withhold some samples from the
  /// destination; null if it gets every sample. The object must outlive the call.
  const core::Wanted* some_samples = nullptr;
  /// True if the destination is in a group whose members are all in this division now.
  bool is_in_group = false;
  double bytes_per_s = 0;  ///< rate of data for the destination without a group; 0: not known yet
};

struct Division {
  std::size_t number = 0;
  std::string_view refusal{};  ///< reason why the destination can be in no group; empty if it can be in one
};

/// The maximum number of divisions with conditions or a maximum rate that may have groups on one link.
/// Divisions that have a group are preferred, and then those with the highest rates.
inline constexpr std::size_t some_samples_groups_max = 8;

/// Returns the division of each destination. All destinations of a division are on the same link, and get
/// the same samples. If these are not all samples, the destinations also request the same fields, because
/// every reader whose mask a merged sample contains takes that sample.
std::vector<Division> divide(std::span<const DividedPlace> places);

}  // namespace sft::udp
