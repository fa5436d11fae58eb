// The reference for small samples over UDP: two processes with a socket each.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "bench/common/hosts.h"
#include "bench/common/transfer.h"

namespace sft::bench {

/// Half round trips in microseconds, with blocking sockets, or with both sides asking theirs again and again.
/// So long after one has come back the next one goes.
std::vector<double> raw_socket_ping_pong(std::uint64_t messages, std::size_t bytes, Reading reading,
                                         const TwoHosts& hosts, std::int64_t pause_us = 0);

}  // namespace sft::bench
