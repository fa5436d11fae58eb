// Sends datagrams through one connected socket for each address. The sending thread polls the sockets whose
// send buffers are full.
#pragma once

#include <memory>

#include "udp_transport/io/datagram_io.h"
#include "udp_transport/io/udp_socket.h"

namespace sft::udp {

/// The maximum number of addresses that have their own socket. Further addresses share the receiving socket
/// and its send buffer.
inline constexpr std::size_t sending_sockets_max = 256;

/// Opens a sender. Its connections send from the address that `socket` is bound to. Their send buffers have
/// the size that was requested for `socket`.
Result<std::unique_ptr<DatagramSender>> open_socket_sender(std::shared_ptr<const UdpSocket> socket);

}  // namespace sft::udp
