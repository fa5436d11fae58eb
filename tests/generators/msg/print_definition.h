// A definition as the text of a .msg file.
#pragma once

#include <string>

#include "from_msg/definition.h"

namespace sft::msg::test {

/// Parses to `definition` again, but for the numbers of lines.
std::string print(const Definition& definition);

}  // namespace sft::msg::test
