// Descriptions of endpoints and pairs, as JSON for programs and as text for people.
#pragma once

#include <sft/domain.h>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace sft::tool {

// The names in the JSON objects must not change; later versions may add names.
nlohmann::ordered_json endpoint_json(const DomainSnapshot::Endpoint& endpoint, bool publishes);
/// Returns a pair as a JSON object. Counters that a node has not reported are null.
nlohmann::ordered_json pair_json(const DomainSnapshot::Pair& pair, const DomainSnapshot::Endpoint& publisher,
                                 const DomainSnapshot::Endpoint& subscriber);

/// Returns a text such as "reliable, transient_local, keep last 10, deadline 100 ms".
std::string qos_text(const Qos& qos);
/// Returns a text such as "height, width; at most 20 Hz".
std::string request_text(const DomainSnapshot::Endpoint& subscriber);
/// Returns the hash of an endpoint's type. For an endpoint of DDS, this is the hash that ROS 2 announces,
/// or "-" if there is none.
std::string type_hash_text(const DomainSnapshot::Endpoint& endpoint);
/// Returns the transports that an endpoint may use, such as "shm, udp".
std::string ways_text(const DomainSnapshot::Endpoint& endpoint);
/// Returns one line such as "matched by udp: another host" or "not matched: ...".
std::string verdict_text(const DomainSnapshot::Pair& pair);

const DomainSnapshot::Endpoint* endpoint_of(std::uint64_t id,
                                            const std::vector<DomainSnapshot::Endpoint>& endpoints);

}  // namespace sft::tool
