// Handles the answers of receivers: acks, reports, and reports of members of multicast groups.
#pragma once

#include <chrono>
#include <cstddef>
#include <span>

#include "udp_transport/send/send_side.h"
#include "udp_transport/wire/datagram.h"

namespace sft::udp {

/// Handles an answer. Returns Wake::look if a lane or channel that waited may continue. An answer is
/// rejected and counted if it does not belong to any sent data, or comes from an address to which no data
/// was sent. Must be called by only one thread: the sending thread, or the receiving thread if there is no
/// port for answers.
[[nodiscard]] Wake hear_answer(SendSide& side, const Answer& answer, const SocketAddress& from,
                               std::chrono::steady_clock::time_point now) noexcept;

/// Handles an answer that is still encoded. A datagram that is not a well-formed answer is counted as
/// malformed.
[[nodiscard]] Wake hear_answer(SendSide& side, std::span<const std::byte> datagram, const SocketAddress& from,
                               std::chrono::steady_clock::time_point now) noexcept;

}  // namespace sft::udp
