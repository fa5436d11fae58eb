// `sft ls`: lists nodes, topics, types or endpoints.
#pragma once

#include <string>

#include "tools/sft/session.h"

namespace sft::tool {

struct LsOptions {
  std::string what{};  ///< "nodes", "topics", "types" or "endpoints"; empty: topics, or all of these as JSON
  bool names = false;  ///< true: prints names only, one per line
};

ExitCode run(const LsOptions& options, const CommonOptions& common, Session& session);

}  // namespace sft::tool
