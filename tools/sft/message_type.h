// Where the type of a publisher comes from.
#pragma once

#include <string>
#include <vector>

#include "tools/sft/session.h"

namespace sft::tool {

/// What the user names a type by.
struct TypeChoice {
  /// "sensor_msgs/PointCloud2" and its longer forms; a file, "my_msgs/msg/Status.msg"; or "auto": the type
  /// that somebody announces for the topic.
  std::string type{};
  std::vector<std::string> includes{};  ///< more directories of packages
};

/// A name is looked for in the directories, in the messages that are installed with SFT, and then, for the
/// timeout of the session, among the types that anybody announces. Errc::unavailable if it is nowhere.
Result<DynamicType> find_message_type(const TypeChoice& choice, const std::string& topic, Session& session);

}  // namespace sft::tool
