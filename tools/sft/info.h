// `sft info`: shows the publishers and subscribers of a topic, and their settings.
#pragma once

#include <string>

#include "tools/sft/session.h"

namespace sft::tool {

struct InfoOptions {
  std::string topic{};
};

ExitCode run(const InfoOptions& options, const CommonOptions& common, Session& session);

}  // namespace sft::tool
