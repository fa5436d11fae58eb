// `sft pub`: publishes messages that are written as YAML or JSON.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "tools/sft/session.h"

namespace sft::tool {

struct PubOptions {
  std::string topic{};
  /// "sensor_msgs/PointCloud2" and its longer forms; a file, "my_msgs/msg/Status.msg"; or "auto", which is
  /// the type that another node announces for the topic.
  std::string type{};
  std::string value = "{}";         ///< YAML or JSON; "-": messages from the standard input, each once
  std::optional<double> rate_hz{};  ///< nothing: 1, or as fast as messages come from the standard input
  std::uint64_t count = 0;          ///< 0: until the user stops it, or until the end of the input
  bool reliable = false;
  bool transient_local = false;
  std::optional<std::size_t> wait_for{};  ///< subscribers; nothing: 1 if the command ends by itself, else 0
};

ExitCode run(const PubOptions& options, const CommonOptions& common, Session& session);

}  // namespace sft::tool
