// Handles the answers to what was sent: acks, and reports of receivers and of members of groups.
#pragma once

#include <chrono>
#include <cstddef>
#include <span>

#include "udp_transport/send/send_side.h"
#include "udp_transport/wire/datagram.h"

namespace sft::udp {

/// Returns Wake::look if something that waited may go on. An answer is rejected and counted if it answers
/// nothing that was sent, or comes from another address than that was sent to. Used by one thread: the
/// sending thread, or the receiving thread if there is no port for answers.
[[nodiscard]] Wake hear_answer(SendSide& side, const Answer& answer, const SocketAddress& from,
                               std::chrono::steady_clock::time_point now) noexcept;

/// Handles an encoded answer in the same way. A datagram that is no well-formed answer is counted as
/// malformed.
[[nodiscard]] Wake hear_answer(SendSide& side, std::span<const std::byte> datagram, const SocketAddress& from,
                               std::chrono::steady_clock::time_point now) noexcept;

}  // namespace sft::udp
