// Chooses whether a node serves and hears unmodified nodes of DDS, and by which names.
#pragma once

#include "sft/options.h"
#include "sft/result.h"

namespace sft::core {

/// Returns the choice of the program, or else that of `environment` (the value of SFT_VANILLA_DDS, or null),
/// or else `automatic`. The error names the possible values.
Result<NodeOptions::VanillaDds> vanilla_choice(std::optional<NodeOptions::VanillaDds> program,
                                               const char* environment);
/// Returns the choice of the program, or else that of `environment` (the value of SFT_DDS_NAMES, or null), or
/// else `ros2`. The error names the possible values.
Result<NodeOptions::DdsNames> dds_names_choice(std::optional<NodeOptions::DdsNames> program,
                                               const char* environment);

}  // namespace sft::core
