// What a reader asks for, as its writer understands it.
#pragma once

#include "core/control/control.h"
#include "sft/type_support.h"

namespace sft::core {

/// Closed, and without a gate. An error if the request is for parts that the type does not have: anybody may
/// have sent it.
Result<Selection> requested_selection(const Request& request, const TypeSupport& type);

}  // namespace sft::core
