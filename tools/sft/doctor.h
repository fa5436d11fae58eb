// `sft doctor`: checks whether this host is set up well for SFT, and says how to correct what is not.
#pragma once

#include "tools/sft/session.h"

namespace sft::tool {

struct DoctorOptions {
  bool quiet = false;  ///< print warnings and errors only
};

/// Opens its own node, since a node that does not open is a finding.
ExitCode run(const DoctorOptions& options, const CommonOptions& common, Stop& stop, Output& output);

}  // namespace sft::tool
