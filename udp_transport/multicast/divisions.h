// Tells which destinations may share a multicast group at all. Uses no clock, thread or I/O.
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
  /// If only some samples are for the destination (those that pass conditions or a maximum rate), what all
  /// its readers ask for. Null: every sample is for it. Outlives the call.
  const core::Wanted* some_samples = nullptr;
  bool is_in_group = false;  ///< the place is in a group of places that are in this division now
  double bytes_per_s = 0;    ///< rate that the place is sent if served alone; 0: not known yet
};

struct Division {
  std::size_t number = 0;
  std::string_view refusal{};  ///< why the place can be in no group; empty if it can be
};

/// The number of divisions behind a link that may have groups although only some samples are for them.
/// Divisions that have a group come first, and then those that are sent most.
inline constexpr std::size_t some_samples_groups_max = 8;

/// Returns the division of each place. Only places of one division may share a group: they are behind the
/// same link, and the same samples are for them. If only some samples are for them, they also ask for the
/// same fields, since a merged sample is for every reader whose mask it contains.
std::vector<Division> divide(std::span<const DividedPlace> places);

}  // namespace sft::udp
