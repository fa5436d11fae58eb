// `sft delay`: how old samples are when they come.
#pragma once

#include <string>

#include "tools/sft/live.h"

namespace sft::tool {

struct DelayOptions {
  std::string topic{};
  bool published = false;  ///< since they were published, by the publisher's clock, and not by header.stamp
  LiveOptions live{};
};

ExitCode run(const DelayOptions& options, const CommonOptions& common, Session& session);

}  // namespace sft::tool
