// `sft top`: shows the topics and pairs of the domain live, on the whole screen.
#pragma once

#include "tools/sft/session.h"

namespace sft::tool {

struct TopOptions {
  double every_s = 1;
  double for_s = 0;  ///< the duration in seconds; 0: until the user stops the command
};

ExitCode run(const TopOptions& options, const CommonOptions& common, Session& session);

}  // namespace sft::tool
