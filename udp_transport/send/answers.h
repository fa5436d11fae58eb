// What comes back to those who send: acks, and reports of receivers and of members of groups.
#pragma once

#include <chrono>
#include <cstddef>
#include <span>

#include "udp_transport/send/send_side.h"
#include "udp_transport/wire/datagram.h"

namespace sft::udp {

/// True if somebody who waits may go on: the sending thread has to look. Counts what is malformed, and what
/// is no answer as that; and what is not believed: an answer of nothing that we sent, or from an address that
/// is none of whom we sent it to. Of one thread: the one that sends, or where there is no port for answers
/// the one that receives.
[[nodiscard]] bool hear_answer(SendSide& side, std::span<const std::byte> datagram, const SocketAddress& from,
                               std::chrono::steady_clock::time_point now) noexcept;

}  // namespace sft::udp
