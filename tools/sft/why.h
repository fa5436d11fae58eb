// `sft why`: shows whether publishers and subscribers of a topic match, by which path samples go and why, and
// how much was sent, saved, withheld and lost.
#pragma once

#include <string>

#include "tools/sft/session.h"

namespace sft::tool {

struct WhyOptions {
  std::string topic{};
  bool types = false;  ///< print both definitions of a type if they differ
};

/// Returns ExitCode::nothing also if a pair does not match, or if there is no pair.
ExitCode run(const WhyOptions& options, const CommonOptions& common, Session& session);

}  // namespace sft::tool
