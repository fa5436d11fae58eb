// `sft ls`: what is there.
#pragma once

#include <string>

#include "tools/sft/session.h"

namespace sft::tool {

struct LsOptions {
  std::string what{};  ///< "nodes", "topics", "types" or "endpoints"; empty: topics, as JSON all of these
  bool names = false;  ///< only names, one in a line
};

ExitCode run(const LsOptions& options, const CommonOptions& common, Session& session);

}  // namespace sft::tool
