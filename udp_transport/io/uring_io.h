// Datagrams through io_uring: one multishot receive into a ring of provided buffers. Sending uses plain
// calls (socket_sender.h), because a ring takes no fewer cycles for that. Only uring_io.cpp includes
// liburing.
#pragma once

#include <memory>
#include <string_view>

#include "udp_transport/io/datagram_io.h"
#include "udp_transport/io/udp_socket.h"

namespace sft::udp {

/// The beginning of errors of open_uring_io(); the reason follows.
inline constexpr std::string_view no_io_uring = "io_uring cannot be used: ";

/// Opens io_uring. The error gives the kernel's reason to refuse: it is too old (before 6.1), forbids
/// io_uring (seccomp, sysctl), or may lock too little memory.
Result<DatagramIo> open_uring_io(std::shared_ptr<const UdpSocket> socket);

}  // namespace sft::udp
