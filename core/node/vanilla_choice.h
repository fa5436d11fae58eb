// Chooses whether the publishers of a node serve unmodified nodes of DDS.
#pragma once

#include "sft/options.h"
#include "sft/result.h"

namespace sft::core {

/// Returns the choice of the program, or else that of `environment` (the value of SFT_VANILLA_DDS, or null),
/// or else `automatic`. The error names the possible values.
Result<NodeOptions::VanillaDds> vanilla_choice(std::optional<NodeOptions::VanillaDds> program,
                                               const char* environment);

}  // namespace sft::core
