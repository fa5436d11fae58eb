// Chooses the DDS domain of a node.
#pragma once

#include <cstdint>
#include <optional>

#include "sft/result.h"

namespace sft::core {

inline constexpr std::uint32_t domain_max = 232;  ///< by the port numbers that DDS derives from it

/// Returns the domain that the program names; else the one in `environment` ($ROS_DOMAIN_ID; may be null);
/// else 0.
Result<std::uint32_t> domain_id(std::optional<std::uint32_t> program, const char* environment);

}  // namespace sft::core
