// Finds the message type that a publisher is to use.
#pragma once

#include <string>
#include <vector>

#include "tools/sft/session.h"

namespace sft::tool {

/// The type as the user names it.
struct TypeChoice {
  /// "sensor_msgs/PointCloud2" and its longer forms; a file, "my_msgs/msg/Status.msg"; or "auto", which is
  /// the type that another node announces for the topic.
  std::string type{};
  std::vector<std::string> includes{};  ///< directories of packages, besides the messages of SFT
};

/// Looks for a name in the directories, in the messages that are installed with SFT, and then, for the
/// timeout of the session, among the types that nodes announce. Errc::unavailable if no place has it.
Result<DynamicType> find_message_type(const TypeChoice& choice, const std::string& topic, Session& session);

}  // namespace sft::tool
