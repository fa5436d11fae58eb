// `sft type`: prints the message type of a topic, or the type with a given name.
#pragma once

#include <string>

#include "tools/sft/session.h"

namespace sft::tool {

struct TypeOptions {
  std::string topic{};  ///< the topic, or the name of a type: "sensor_msgs/PointCloud2" and its longer forms
  bool name = false;    ///< true: prints the name of the type only
  bool fields = false;  ///< true: prints the fields only, as `sft echo --fields` takes them
};

ExitCode run(const TypeOptions& options, const CommonOptions& common, Session& session);

}  // namespace sft::tool
