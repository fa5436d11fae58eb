// Chooses the DDS domain of a node.
#pragma once

#include <cstdint>
#include <optional>

#include "sft/result.h"

namespace sft::core {

/// Returns the domain that the program names. If it names none, returns the domain in `environment` (the
/// value of $ROS_DOMAIN_ID; may be null), and if there is none either, 0. The error names the valid
/// domains.
Result<std::uint32_t> domain_id(std::optional<std::uint32_t> program, const char* environment);

}  // namespace sft::core
