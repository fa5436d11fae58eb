// Checks names by the rules of ROS 2, with a limit of 255 bytes.
#pragma once

#include <string_view>

namespace sft::msg {

/// Returns true for lower-case letters, digits and single underscores. The first character must be a letter,
/// and the last one no underscore.
bool is_package_name(std::string_view name);
bool is_field_name(std::string_view name);

/// Returns true for upper-case letters, digits and single underscores. The first character must be a
/// letter, and the last one no underscore.
bool is_constant_name(std::string_view name);

/// Returns true for a name of letters and digits that begins with a capital letter. It may have the
/// prefixes and suffixes of ROS 2's generated names.
bool is_message_name(std::string_view name);

}  // namespace sft::msg
