// Datagrams through plain socket calls, for kernels and containers that refuse io_uring. The throughput is
// that of io_uring, since it depends on segmentation (GSO, GRO). But each wake-up costs one more system
// call.
#pragma once

#include <memory>

#include "udp_transport/io/datagram_io.h"
#include "udp_transport/io/udp_socket.h"

namespace sft::udp {

Result<DatagramIo> open_socket_io(std::shared_ptr<const UdpSocket> socket);

}  // namespace sft::udp
