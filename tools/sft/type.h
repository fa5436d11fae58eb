// `sft type`: prints the message type of a topic.
#pragma once

#include <string>

#include "tools/sft/session.h"

namespace sft::tool {

struct TypeOptions {
  std::string topic{};
  bool name = false;    ///< print the name of the type only
  bool fields = false;  ///< print the fields only, as `sft echo --fields` takes them
};

ExitCode run(const TypeOptions& options, const CommonOptions& common, Session& session);

}  // namespace sft::tool
