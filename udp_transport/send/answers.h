// Handles what comes back to those who send: acks, and reports of receivers and of members of groups.
#pragma once

#include <chrono>
#include <cstddef>
#include <span>

#include "udp_transport/send/send_side.h"
#include "udp_transport/wire/datagram.h"

namespace sft::udp {

/// Wake::look if something that waited may go on. An answer that is not believed is counted: it answers
/// nothing that was sent, or comes from another address than that was sent to. Used by one thread: the
/// sending one, or the receiving one where there is no port for answers.
[[nodiscard]] Wake hear_answer(SendSide& side, const Answer& answer, const SocketAddress& from,
                               std::chrono::steady_clock::time_point now) noexcept;

/// The same. A datagram that is no sound answer is counted as malformed.
[[nodiscard]] Wake hear_answer(SendSide& side, std::span<const std::byte> datagram, const SocketAddress& from,
                               std::chrono::steady_clock::time_point now) noexcept;

}  // namespace sft::udp
