// `sft doctor`: checks if this host is set up well for SFT, and prints how to correct faults.
#pragma once

#include "tools/sft/session.h"

namespace sft::tool {

struct DoctorOptions {
  bool quiet = false;  ///< true: prints warnings and errors only
};

/// Runs the checks. The command opens its own node, because a node that cannot be opened is one of its
/// findings.
ExitCode run(const DoctorOptions& options, const CommonOptions& common, Stop& stop, Output& output);

}  // namespace sft::tool
