// `sft hz`: measures the rate at which samples of topics arrive.
#pragma once

#include <string>
#include <vector>

#include "tools/sft/live.h"

namespace sft::tool {

struct HzOptions {
  std::vector<std::string> topics{};
  LiveOptions live{};
};

/// Runs the command. It requests no field at all, so that the network carries only the headers of samples,
/// even if they are large.
ExitCode run(const HzOptions& options, const CommonOptions& common, Session& session);

}  // namespace sft::tool
