// What a reader asks for, as its writer understands it.
#pragma once

#include "core/control/control.h"
#include "sft/type_support.h"

namespace sft::core {

/// Closed, and without a rate. An error if the request is for parts or has conditions that the type does not
/// have: anybody may have sent it.
Result<Selection> requested_selection(const Request& request, const TypeSupport& type);

/// The maximum rate of the selection, in Hz; 0: none.
double rate_hz_of(const Selection& selection);

/// The selection, closed, with its gate. An error if it is not one of that type.
Result<Selection> checked_selection(const TypeSupport& type, const Selection& selection);

}  // namespace sft::core
