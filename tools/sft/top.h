// `sft top`: what goes on in the domain, live, on the whole screen.
#pragma once

#include "tools/sft/session.h"

namespace sft::tool {

struct TopOptions {
  double every_s = 1;
  double for_s = 0;  ///< 0: until it is stopped
};

ExitCode run(const TopOptions& options, const CommonOptions& common, Session& session);

}  // namespace sft::tool
