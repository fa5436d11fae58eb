// `sft doctor`: whether this host is set up well for SFT, and what to do where it is not.
#pragma once

#include "tools/sft/session.h"

namespace sft::tool {

struct DoctorOptions {
  bool quiet = false;  ///< only what is not well
};

/// Opens its own node, since what keeps a node from opening is a finding.
ExitCode run(const DoctorOptions& options, const CommonOptions& common, Stop& stop, Output& output);

}  // namespace sft::tool
