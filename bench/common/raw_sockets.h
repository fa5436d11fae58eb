// The reference for small samples over UDP: two processes with one socket each.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "bench/common/hosts.h"
#include "bench/common/transfer.h"

namespace sft::bench {

/// Returns half of the time of each round trip, in microseconds. Both sides block in their socket, or poll
/// it in a loop. Each datagram is sent `pause_us` after the previous datagram has returned.
std::vector<double> raw_socket_ping_pong(std::uint64_t messages, std::size_t bytes, Reading reading,
                                         const TwoHosts& hosts, std::int64_t pause_us = 0);

}  // namespace sft::bench
