// Where acks and reports may go. A datagram can come from anywhere and name any port: nobody is answered but
// at an address that the node of a writer has announced. Pure.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "core/seam/transport.h"
#include "udp_transport/io/datagram_io.h"

namespace sft::udp {

/// Whether that node has announced the address. Link-local addresses are compared without their scope.
bool is_announced(const core::Announced& node, const core::IpAddress& ip);

/// Where to answer a datagram of that node that came from `from`, and expects answers at `port`: there if the
/// address was announced, and else at an announced one of the same family. Empty if there is none, or if the
/// port is a privileged one that was not announced.
std::optional<SocketAddress> answer_address(const core::Announced& node, const core::IpAddress& from,
                                            std::uint16_t port);

}  // namespace sft::udp
