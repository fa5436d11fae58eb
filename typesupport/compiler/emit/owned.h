// Writes the first section of a header: constants, aliases, enumerations, and the structs that own the values
// of messages.
#pragma once

#include <vector>

#include "code.h"
#include "message.h"

namespace sft::idl {

/// Writes all declarations of `file` in their order, each in its namespace. `messages` are the structs of the
/// file, in the same order.
void emit_owned(Code& code, const sft_file& file, const std::vector<Message>& messages);

}  // namespace sft::idl
