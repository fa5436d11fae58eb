// Sends through a connected socket for each address, which the sending thread polls where they are full.
#pragma once

#include <memory>

#include "udp_transport/io/datagram_io.h"
#include "udp_transport/io/udp_socket.h"

namespace sft::udp {

/// More addresses than that are sent to through the socket that receives, whose send buffer they share.
inline constexpr std::size_t sending_sockets_max = 256;

/// The connections of this sender send from the address that `socket` is bound to, with the send buffers that
/// were asked for `socket`.
Result<std::unique_ptr<DatagramSender>> open_socket_sender(std::shared_ptr<const UdpSocket> socket);

}  // namespace sft::udp
