// Writes the last sections of a header: the getters of lazy views, and the writable spans of loans.
#pragma once

#include "code.h"
#include "message.h"

namespace sft::idl {

void emit_view(Code& code, const Message& message);
void emit_loan_view(Code& code, const Message& message);

}  // namespace sft::idl
