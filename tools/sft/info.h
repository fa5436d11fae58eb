// `sft info`: who publishes a topic and who subscribes to it, and how.
#pragma once

#include <string>

#include "tools/sft/session.h"

namespace sft::tool {

struct InfoOptions {
  std::string topic{};
};

ExitCode run(const InfoOptions& options, const CommonOptions& common, Session& session);

}  // namespace sft::tool
