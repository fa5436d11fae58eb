// Whether an unmodified DDS reader can be served by a publisher: what the reader asks for beside what SFT
// offers to such readers. DDS decides by itself whether the two match; this says why not, in words. Pure.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "sft/qos.h"

namespace sft::core {

/// What an endpoint for unmodified peers says in its user data. `type_hash`: of ros_type_hash(); empty: none.
std::string endpoint_user_data(std::string_view type_hash);

/// A reader as DDS announces it. A duration of 0 means none.
struct VanillaReader {
  std::string type_name{};
  Qos qos{};                              ///< what it requests, as far as SFT has these policies
  std::vector<std::string> partitions{};  ///< empty: the one of those that name none
  bool takes_xcdr1 = true;                ///< the representation in which SFT has its samples
  bool is_keyed = false;
  bool owns_exclusively = false;
};

/// Returns what a publisher offers to unmodified readers. It resends to those that ask for it, and keeps what
/// it retains for them. Liveliness is that of its process, and no lease is promised.
Qos offered_to_vanilla(const Qos& publisher);

/// Returns everything that does not fit, or an empty text. `type_name` is the one of DDS.
std::string why_not_served(std::string_view type_name, const Qos& offered, const VanillaReader& reader);

}  // namespace sft::core
