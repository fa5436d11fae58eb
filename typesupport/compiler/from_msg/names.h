// ROS 2's rules for names, and a limit of 255 bytes.
#pragma once

#include <string_view>

namespace sft::msg {

/// True for lower-case letters, digits and single underscores; the first one is a letter, the last one no
/// underscore.
bool is_package_name(std::string_view name);
bool is_field_name(std::string_view name);

/// True for the same with upper-case letters.
bool is_constant_name(std::string_view name);

/// True for letters and digits that begin with a capital, with or without the prefixes and suffixes of ROS
/// 2's generated names.
bool is_message_name(std::string_view name);

}  // namespace sft::msg
