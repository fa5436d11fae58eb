// `sft type`: prints the message type of a topic, or the type with a given name.
#pragma once

#include <string>

#include "tools/sft/session.h"

namespace sft::tool {

struct TypeOptions {
  std::string topic{};  ///< the topic, or the name of a type, such as "sensor_msgs/PointCloud2" or one of its
                        ///< longer forms
  bool name = false;    ///< true: prints the name of the type only
  bool fields = false;  ///< true: prints the fields only, in the form that `sft echo --fields` accepts
};

ExitCode run(const TypeOptions& options, const CommonOptions& common, Session& session);

}  // namespace sft::tool
