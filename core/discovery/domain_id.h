// Which DDS domain a node is in.
#pragma once

#include <cstdint>
#include <optional>

#include "sft/result.h"

namespace sft::core {

inline constexpr std::uint32_t domain_max = 232;  ///< by the port numbers that DDS derives from it

/// What the program says; else what `environment` ($ROS_DOMAIN_ID; may be null) says; else 0.
Result<std::uint32_t> domain_id(std::optional<std::uint32_t> program, const char* environment);

}  // namespace sft::core
