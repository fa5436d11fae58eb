// Decodes the selection that a reader requests, for its writer.
#pragma once

#include "core/control/control.h"
#include "sft/type_support.h"

namespace sft::core {

/// Returns the selection, closed (with all fields that its conditions and parts need), and without a rate.
/// Returns an error if parts or conditions of the request do not fit the type, since the request may be
/// hostile.
Result<Selection> requested_selection(const Request& request, const TypeSupport& type);

/// Returns the maximum rate of the selection, in Hz; 0: none.
double rate_hz_of(const Selection& selection);

/// Returns the selection, closed and with its gate. Returns an error if the selection does not fit the
/// type.
Result<Selection> checked_selection(const TypeSupport& type, const Selection& selection);

}  // namespace sft::core
