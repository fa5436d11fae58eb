// The topics that a node has seen.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "sft/typesupport/dynamic_type.h"

namespace sft {

/// One type of a topic, and the names of the nodes that use it, one for each publisher and subscriber.
struct TopicType {
  std::string name;                        ///< as in the IDL: "sensor_msgs::msg::Imu"
  std::uint64_t hash = 0;                  ///< equal for equal definitions of the type
  std::optional<DynamicType> type{};       ///< its fields; nothing where it is too large to be described
  std::vector<std::string> publishers{};   ///< names of nodes
  std::vector<std::string> subscribers{};  ///< names of nodes
};

/// One topic, and the types that it is used with.
struct TopicInfo {
  /// Without a slash at the beginning.
  std::string name;
  std::vector<TopicType> types{};  ///< more than one: these publishers and subscribers do not match
};

}  // namespace sft
