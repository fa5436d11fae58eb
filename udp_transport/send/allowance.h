// Computes how many bytes of a sample may be sent now.
#pragma once

#include <cstddef>

#include "udp_transport/flow/destination.h"
#include "udp_transport/flow/rate_limit.h"
#include "udp_transport/reliable/resend_window.h"

namespace sft::udp {

/// Returns the number of socket bytes of one sample that may be sent to the destination now. The window of
/// the destination, the rate limit of the writer, and the rate limit of all writers together determine that
/// number. Any thread may call this.
std::size_t allowance(Destination& to, RateLimit& of_writer, RateLimit& of_all, ResendWindow::Size size,
                      Destination::Time now);

}  // namespace sft::udp
