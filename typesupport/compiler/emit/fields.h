// Writes the third section of a header: names of fields as static members, so that
// Cloud::Field::header.stamp.sec names a leaf.
#pragma once

#include "code.h"
#include "message.h"

namespace sft::idl {

void emit_fields(Code& code, const Message& message);

}  // namespace sft::idl
