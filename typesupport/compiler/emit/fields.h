// Writes the third section of a header: the names of fields as static members. So
// Cloud::Field::header.stamp.sec names a leaf.
#pragma once

#include "code.h"
#include "message.h"

namespace sft::idl {

void emit_fields(Code& code, const Message& message);

}  // namespace sft::idl
