// Determines the destinations that may share a multicast group at all. Uses no clock, thread or I/O.
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
  /// The union of the readers' requests, if only the samples that pass conditions or a maximum rate are for
  /// the destination. Null: every sample is for the destination. The object must outlive the call.
  const core::Wanted* some_samples = nullptr;
  bool is_in_group = false;  ///< true if the place is in a group whose places are all in this division now
  double bytes_per_s = 0;    ///< rate that is sent to the place if it is served alone; 0: not known yet
};

struct Division {
  std::size_t number = 0;
  std::string_view refusal{};  ///< reason why the place can be in no group; empty if it can be in one
};

/// The number of divisions with conditions or a maximum rate that may have groups behind one link.
/// Divisions that have a group come first, and then those with the highest rates.
inline constexpr std::size_t some_samples_groups_max = 8;

/// Returns the division of each place. Only places of one division may share a group: they are behind the
/// same link, and the same samples are for them. If that is only a part of the samples, the places also
/// request the same fields, since a merged sample is for every reader whose mask it contains.
std::vector<Division> divide(std::span<const DividedPlace> places);

}  // namespace sft::udp
