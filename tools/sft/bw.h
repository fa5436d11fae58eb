// `sft bw`: measures the bytes per second of a topic.
#pragma once

#include <string>

#include "tools/sft/live.h"

namespace sft::tool {

struct BwOptions {
  std::string topic{};
  std::string fields = "*";
  bool every = false;  ///< true: measures every sample; false: measures one sample per second, and the rate
  LiveOptions live{};
};

/// Runs the command. Unless `every` is set, the network carries one whole sample per second, and only the
/// headers of all other samples.
ExitCode run(const BwOptions& options, const CommonOptions& common, Session& session);

}  // namespace sft::tool
