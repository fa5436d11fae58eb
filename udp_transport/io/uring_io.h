// Datagrams through io_uring: one multishot receive into a ring of provided buffers. They are sent as
// everywhere (socket_sender.h): a ring takes no fewer cycles for that. The only part that knows liburing.
#pragma once

#include <memory>
#include <string_view>

#include "udp_transport/io/datagram_io.h"
#include "udp_transport/io/udp_socket.h"

namespace sft::udp {

/// What errors of open_uring_io() begin with; the reason follows.
inline constexpr std::string_view no_io_uring = "io_uring cannot be used: ";

/// The error says why the kernel refused: too old (before 6.1),
/// forbidden (seccomp, sysctl) or out of locked memory.
Result<DatagramIo> open_uring_io(std::shared_ptr<const UdpSocket> socket);

}  // namespace sft::udp
