// `sft why`: shows if publishers and subscribers of a topic match, the path of the samples and the reason
// for this path, and the numbers of samples sent, saved, withheld and lost.
#pragma once

#include <string>

#include "tools/sft/session.h"

namespace sft::tool {

struct WhyOptions {
  std::string topic{};
  bool types = false;  ///< true: prints both definitions of a type if they differ
};

/// Runs the command. Also returns ExitCode::nothing if a pair does not match, or if there is no pair.
ExitCode run(const WhyOptions& options, const CommonOptions& common, Session& session);

}  // namespace sft::tool
