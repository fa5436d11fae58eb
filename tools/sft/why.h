// `sft why`: whether publishers and subscribers of a topic match, by which path samples go and why, and what
// was sent, saved, withheld and lost.
#pragma once

#include <string>

#include "tools/sft/session.h"

namespace sft::tool {

struct WhyOptions {
  std::string topic{};
  bool types = false;  ///< where definitions of a type differ, both as a whole
};

/// ExitCode::nothing also if a pair does not match, or there is none.
ExitCode run(const WhyOptions& options, const CommonOptions& common, Session& session);

}  // namespace sft::tool
