// Descriptions of endpoints and pairs, as JSON for programs and as text for people.
#pragma once

#include <sft/domain.h>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace sft::tool {

// The names in these objects are stable; later versions may add names.
nlohmann::ordered_json endpoint_json(const EndpointInfo& endpoint, bool publishes);
/// Counters that their node has not reported are null.
nlohmann::ordered_json pair_json(const PairInfo& pair, const EndpointInfo& publisher,
                                 const EndpointInfo& subscriber);

/// "reliable, transient_local, keep last 10, deadline 100 ms"
std::string qos_text(const Qos& qos);
/// "height, width; at most 20 Hz"
std::string request_text(const EndpointInfo& subscriber);
/// "shm, udp"
std::string ways_text(const EndpointInfo& endpoint);
/// "matched by udp: another host", "not matched: ...", in one line.
std::string verdict_text(const PairInfo& pair);

const EndpointInfo* endpoint_of(std::uint64_t id, const std::vector<EndpointInfo>& endpoints);

}  // namespace sft::tool
