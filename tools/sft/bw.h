// `sft bw`: how many bytes a topic has in a second.
#pragma once

#include <string>

#include "tools/sft/live.h"

namespace sft::tool {

struct BwOptions {
  std::string topic{};
  std::string fields = "*";
  bool every = false;  ///< measure every sample, instead of one in a second and the rate
  LiveOptions live{};
};

/// Unless every sample is to be measured, costs the network one whole sample a second, and of all others the
/// headers.
ExitCode run(const BwOptions& options, const CommonOptions& common, Session& session);

}  // namespace sft::tool
