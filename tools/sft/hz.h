// `sft hz`: measures how often samples of topics arrive.
#pragma once

#include <string>
#include <vector>

#include "tools/sft/live.h"

namespace sft::tool {

struct HzOptions {
  std::vector<std::string> topics{};
  LiveOptions live{};
};

/// Asks for no field at all, so that the network carries only the headers of a sample, however large it is.
ExitCode run(const HzOptions& options, const CommonOptions& common, Session& session);

}  // namespace sft::tool
