// Writes the second section of a header: the type tables, which all code at run time uses.
#pragma once

#include "code.h"
#include "message.h"

namespace sft::idl {

void emit_enum_table(Code& code, const sft_file& file, const sft_declaration& enumeration);
void emit_table(Code& code, const Message& message);

}  // namespace sft::idl
