// Finds the units of fields in comments.
#pragma once

#include <string_view>

namespace sft::msg {

/// Returns the unit in the comment of a field, "m/s" in "speed over ground [m/s]"; empty if the comment has
/// no unit. As in ROS 2, the unit is in brackets. Brackets with a comma contain a range. If several pairs
/// of brackets have no comma, the comment has no unit. The result refers to `comment`.
std::string_view unit_in(std::string_view comment);

}  // namespace sft::msg
