// Chooses the DDS domain of a node.
#pragma once

#include <cstdint>
#include <optional>

#include "sft/result.h"

namespace sft::core {

/// Returns the domain that the program names; else the one in `environment` ($ROS_DOMAIN_ID; may be null);
/// else 0. The error says which domains there are.
Result<std::uint32_t> domain_id(std::optional<std::uint32_t> program, const char* environment);

}  // namespace sft::core
