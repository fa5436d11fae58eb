// Writes the definition of a message as IDL.
#pragma once

#include <string>

#include "from_msg/definition.h"

namespace sft::msg {

/// Returns the text that IDL files include to nest the message: its constants and its struct. Defaults and
/// units are left out, since the message's own header has them.
std::string idl_text(const Definition& definition);

}  // namespace sft::msg
