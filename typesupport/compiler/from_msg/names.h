// The rules of ROS 2 for names, and a limit of 255 bytes.
#pragma once

#include <string_view>

namespace sft::msg {

/// Returns true for lower-case letters, digits and single underscores. The first character must be a letter,
/// and the last one no underscore.
bool is_package_name(std::string_view name);
bool is_field_name(std::string_view name);

/// Returns true for upper-case letters, digits and single underscores, under the same conditions.
bool is_constant_name(std::string_view name);

/// Returns true for letters and digits that begin with a capital letter, with or without the prefixes and
/// suffixes of ROS 2's generated names.
bool is_message_name(std::string_view name);

}  // namespace sft::msg
