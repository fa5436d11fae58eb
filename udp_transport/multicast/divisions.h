// Tells which destinations may share a multicast group at all. Pure: what is asked for goes in, numbers come
// out.
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
  /// What all its readers ask for, if only some samples are for them: those that pass conditions or a maximum
  /// rate. Null: every sample is. Outlives the call.
  const core::Wanted* some_samples = nullptr;
  bool is_in_group = false;  ///< of those places that are in this division now, too
  double bytes_per_s = 0;    ///< that it is sent where it is served alone; 0: not known yet
};

struct Division {
  std::size_t number = 0;
  std::string_view refusal{};  ///< why the place can be in no group; empty if it can be
};

/// Behind a link, so many divisions that are sent some samples only may have groups: those that have one, and
/// then those for which most is sent.
inline constexpr std::size_t some_samples_groups_max = 8;

/// Returns the division of each place. Only places of one division may share a group: they are behind one
/// link, and the same samples are for them. Those that are sent some samples only ask for the same of these,
/// too, since a merged sample is for every reader whose mask it contains.
std::vector<Division> divide(std::span<const DividedPlace> places);

}  // namespace sft::udp
