// Datagrams through io_uring: one multishot receive into a ring of provided buffers. Sending uses plain
// calls (socket_sender.h), because a ring does not make sending cheaper. Only uring_io.cpp includes
// liburing.
#pragma once

#include <memory>
#include <string_view>

#include "udp_transport/io/datagram_io.h"
#include "udp_transport/io/udp_socket.h"

namespace sft::udp {

/// The beginning of the messages of open_uring_io()'s errors; the reason follows.
inline constexpr std::string_view no_io_uring = "io_uring cannot be used: ";

/// Opens io_uring. The error names the reason: the kernel is older than 6.1, io_uring is forbidden (seccomp,
/// sysctl), or this process may lock too little memory.
Result<DatagramIo> open_uring_io(std::shared_ptr<const UdpSocket> socket);

}  // namespace sft::udp
