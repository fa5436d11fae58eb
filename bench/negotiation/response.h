// The time from a getter call for an absent field until the publisher on another host has applied the new
// mask, and that of Cyclone DDS alone.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "bench/common/contender.h"
#include "bench/common/hosts.h"

namespace sft::bench {

/// Returns the response times in microseconds.
std::vector<double> response_times(const TwoHosts& hosts, std::uint64_t messages);

/// Returns Cyclone DDS alone, with SFT's configuration. Its samples are about as large as a request.
/// Durable topics have the QoS of requests.
std::unique_ptr<Peer> cyclone_control_peer();

}  // namespace sft::bench
