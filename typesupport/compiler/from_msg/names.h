// The rules that ROS 2 has for names.
#pragma once

#include <string_view>

namespace sft::msg {

/// Lower case, digits and single underscores; begins with a letter, ends with none of the underscores.
bool is_package_name(std::string_view name);
bool is_field_name(std::string_view name);

/// The same in upper case.
bool is_constant_name(std::string_view name);

/// Letters and digits, the first one a capital; the prefix and the suffixes that ROS 2 makes names of may be
/// around that.
bool is_message_name(std::string_view name);

}  // namespace sft::msg
