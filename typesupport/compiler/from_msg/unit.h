// Finds units in comments.
#pragma once

#include <string_view>

namespace sft::msg {

/// The unit in the comment of a field, "m/s" in "speed over ground [m/s]"; empty if there is none. As in ROS
/// 2, the unit stands in brackets. Brackets with a comma hold a range, and more than one pair without a comma
/// is no unit. The result refers to `comment`.
std::string_view unit_in(std::string_view comment);

}  // namespace sft::msg
