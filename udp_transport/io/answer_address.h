// Determines the address to which acks and reports may be sent. A datagram can come from any host and name
// any port. So answers are sent only to an address that the node of a writer has announced. The functions
// use no clock, thread or I/O.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "core/seam/transport.h"
#include "udp_transport/io/datagram_io.h"

namespace sft::udp {

/// Returns true if that node has announced the address. Link-local addresses are compared without their
/// scope.
bool is_announced(const core::Announced& node, const core::IpAddress& ip);

/// Returns the address to which the answer to a datagram of that node is sent. The datagram came from `from`
/// and expects answers at `port`. The result is `from` if that address was announced, else an announced
/// address of the same family. Returns nothing if there is no such address, or if the port is a privileged
/// port that was not announced.
std::optional<SocketAddress> answer_address(const core::Announced& node, const core::IpAddress& from,
                                            std::uint16_t port);

}  // namespace sft::udp
