// Prints a definition as the text of a .msg file.
#pragma once

#include <string>

#include "from_msg/definition.h"

namespace sft::msg::test {

/// Returns a text that the parser turns into `definition` again, except for the line numbers.
std::string print(const Definition& definition);

}  // namespace sft::msg::test
