// Second section: the tables that everything at run time works from.
#pragma once

#include "code.h"
#include "message.h"

namespace sft::idl {

void emit_enum_table(Code& code, const sft_declaration& enumeration);
void emit_table(Code& code, const Message& message);

}  // namespace sft::idl
