// A definition as IDL.
#pragma once

#include <string>

#include "from_msg/definition.h"

namespace sft::msg {

/// What IDL files include to nest the message: its constants and its struct, without defaults and units,
/// which its own header has.
std::string idl_text(const Definition& definition);

}  // namespace sft::msg
