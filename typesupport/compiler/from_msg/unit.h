// Units in comments.
#pragma once

#include <string_view>

namespace sft::msg {

/// What the comment of a field gives as its unit: "m/s" of "speed over ground [m/s]". As in ROS 2 that is
/// what stands in brackets, provided that only one pair of them holds something without a comma, which would
/// be a range. Refers to `comment`; empty: none given.
std::string_view unit_in(std::string_view comment);

}  // namespace sft::msg
