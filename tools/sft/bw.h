// `sft bw`: measures how many bytes per second a topic has.
#pragma once

#include <string>

#include "tools/sft/live.h"

namespace sft::tool {

struct BwOptions {
  std::string topic{};
  std::string fields = "*";
  bool every = false;  ///< measure every sample, instead of one sample per second and the rate
  LiveOptions live{};
};

/// The network carries one whole sample per second, and only the headers of all others, unless `every` is
/// set.
ExitCode run(const BwOptions& options, const CommonOptions& common, Session& session);

}  // namespace sft::tool
