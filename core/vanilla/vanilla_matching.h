// Compares what an unmodified DDS reader requests with what SFT offers to such readers. DDS itself decides if
// the two match; these functions say in words why they do not. They are pure functions.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "sft/qos.h"

namespace sft::core {

/// Returns the user data of an endpoint for unmodified peers. `type_hash` is a result of ros_type_hash(), or
/// empty if the type has no hash.
std::string endpoint_user_data(std::string_view type_hash);

/// A reader as DDS announces it. A duration of 0 means that the policy is not set.
struct VanillaReader {
  std::string type_name{};
  Qos qos{};                              ///< the requested policies, as far as SFT has them
  std::vector<std::string> partitions{};  ///< empty: the default partition
  bool takes_xcdr1 = true;                ///< accepts XCDR1, the encoding of SFT's samples
  bool is_keyed = false;
  bool owns_exclusively = false;
};

/// Returns the QoS that a publisher offers to unmodified readers. The publisher is reliable for readers that
/// request it, and keeps its retained samples for them. Its liveliness is automatic, without a lease.
Qos offered_to_vanilla(const Qos& publisher);

/// Returns all conflicts in words, or an empty text if there is none. `type_name` is the name in DDS.
std::string why_not_served(std::string_view type_name, const Qos& offered, const VanillaReader& reader);

}  // namespace sft::core
