// `sft record`: writes samples into a file.
#pragma once

#include <string>
#include <vector>

#include "tools/sft/session.h"

namespace sft::tool {

struct RecordOptions {
  std::vector<std::string> topics{};  ///< as parse_topic_selection() takes them
  bool all = false;
  std::string output{};  ///< empty: a name with the present time
  std::string compression = "none";
  double split_mb = 0;  ///< 0: no split
  double split_s = 0;   ///< 0: no split
  double last_s = 0;    ///< 0: everything is written
  std::vector<std::string>
      on{};  ///< conditions, TOPIC@CONDITION or CONDITION for all topics with such fields
  double memory_mb = 1024;
  double for_s = 0;       ///< 0: until the user stops it
  std::string version{};  ///< of this program, for the file
};

ExitCode run(const RecordOptions& options, const CommonOptions& common, Session& session);

}  // namespace sft::tool
