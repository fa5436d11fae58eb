// Chooses whether the publishers of a node serve unmodified nodes of DDS.
#pragma once

#include "sft/options.h"
#include "sft/result.h"

namespace sft::core {

/// Returns what the program says; else what `environment` says ($SFT_VANILLA_DDS; may be null); else
/// automatic. The error says what it can be.
Result<NodeOptions::VanillaDds> vanilla_choice(std::optional<NodeOptions::VanillaDds> program,
                                               const char* environment);

}  // namespace sft::core
