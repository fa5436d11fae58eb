// `sft pub`: publishes messages that are written as YAML or JSON.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "tools/sft/session.h"

namespace sft::tool {

struct PubOptions {
  std::string topic{};
  /// The type: a name such as "sensor_msgs/PointCloud2" or one of its longer forms; a file such as
  /// "my_msgs/msg/Status.msg"; or "auto" for the type that another node announces for the topic.
  std::string type{};
  std::string value = "{}";  ///< YAML or JSON; "-": messages from the standard input, each once
  /// The rate; empty: 1 Hz, or as fast as messages arrive from the standard input.
  std::optional<double> rate_hz{};
  /// The number of messages to publish; 0: the command runs until the user stops it, or until the end of
  /// the input.
  std::uint64_t count = 0;
  bool reliable = false;
  bool transient_local = false;
  /// The number of subscribers to wait for; empty: 1 if the command ends by itself, otherwise 0.
  std::optional<std::size_t> wait_for{};
};

ExitCode run(const PubOptions& options, const CommonOptions& common, Session& session);

}  // namespace sft::tool
