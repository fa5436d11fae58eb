// How much of a sample may be sent now.
#pragma once

#include <cstddef>

#include "udp_transport/flow/destination.h"
#include "udp_transport/flow/rate_limit.h"
#include "udp_transport/reliable/resend_window.h"

namespace sft::udp {

/// Returns how many socket bytes of one sample may go to the destination now, by its window and by the limits
/// of the writer and of all writers. Any thread.
std::size_t allowance(Destination& to, RateLimit& of_writer, RateLimit& of_all, ResendWindow::Size size,
                      Destination::Time now);

}  // namespace sft::udp
