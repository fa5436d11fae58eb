// `sft type`: what a topic's messages look like.
#pragma once

#include <string>

#include "tools/sft/session.h"

namespace sft::tool {

struct TypeOptions {
  std::string topic{};
  bool name = false;    ///< only the name of the type
  bool fields = false;  ///< only the fields, as `sft echo --fields` takes them
};

ExitCode run(const TypeOptions& options, const CommonOptions& common, Session& session);

}  // namespace sft::tool
