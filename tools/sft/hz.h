// `sft hz`: how often the samples of topics come.
#pragma once

#include <string>
#include <vector>

#include "tools/sft/live.h"

namespace sft::tool {

struct HzOptions {
  std::vector<std::string> topics{};
  LiveOptions live{};
};

/// Asks for no field at all, so that a sample costs the network its headers, however large it is.
ExitCode run(const HzOptions& options, const CommonOptions& common, Session& session);

}  // namespace sft::tool
