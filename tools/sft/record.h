// `sft record`: writes samples into a file.
#pragma once

#include <string>
#include <vector>

#include "tools/sft/session.h"

namespace sft::tool {

struct RecordOptions {
  std::vector<std::string> topics{};  ///< texts in the form of parse_topic_selection()
  bool all = false;
  std::string output{};  ///< the file; empty: its name is the present time
  std::string compression = "none";
  double split_mb = 0;  ///< the size in MB at which a new file begins; 0: files are not split by size
  double split_s = 0;   ///< the duration after which a new file begins; 0: files are not split by time
  double last_s = 0;    ///< the length of the window in seconds; 0: everything is written
  std::vector<std::string>
      on{};  ///< triggers: TOPIC@CONDITION, or CONDITION for all topics with the fields of the condition
  double memory_mb = 1024;
  double for_s = 0;       ///< the duration in seconds; 0: until the user stops the command
  std::string version{};  ///< the version of this program, which is written to the file
};

ExitCode run(const RecordOptions& options, const CommonOptions& common, Session& session);

}  // namespace sft::tool
