// `sft delay`: measures the age of samples at their arrival.
#pragma once

#include <string>

#include "tools/sft/live.h"

namespace sft::tool {

struct DelayOptions {
  std::string topic{};
  std::string field{};     ///< a field of the type Time; empty: header.stamp
  bool published = false;  ///< true: measures from the time of publication, instead of header.stamp
  LiveOptions live{};
};

ExitCode run(const DelayOptions& options, const CommonOptions& common, Session& session);

}  // namespace sft::tool
