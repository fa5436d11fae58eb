#include "core/vanilla/ros_discovery.h"

#include <algorithm>
#include <string_view>

#include "core/platform/quotes.h"

namespace sft::core {

namespace {

std::string_view text_of_variable(const char* value) { return value == nullptr ? "" : value; }

std::vector<std::string> split(std::string_view hosts) {
  std::vector<std::string> all;
  while (!hosts.empty()) {
    const std::string_view host = hosts.substr(0, hosts.find(';'));
    if (!host.empty()) all.emplace_back(host);
    hosts.remove_prefix(std::min(hosts.size(), host.size() + 1));
  }
  return all;
}

}  // namespace

/// ROS_LOCALHOST_ONLY is the older variable, and still has an effect if it is 1.
Result<RosDiscovery> ros_discovery(const char* localhost_only, const char* discovery_range,
                                   const char* static_peers) {
  RosDiscovery discovery;
  if (text_of_variable(localhost_only) == "1") {
    discovery.loopback_only = true;
    return discovery;
  }
  const std::string_view range = text_of_variable(discovery_range);
  if (range == "OFF") {
    discovery.is_off = true;
    return discovery;
  }
  if (range == "SYSTEM_DEFAULT") return discovery;
  if (!range.empty() && range != "SUBNET" && range != "LOCALHOST") {
    return fail(Errc::invalid_argument, "the environment variable ROS_AUTOMATIC_DISCOVERY_RANGE is " +
                                            in_quotes(std::string(range)) +
                                            ", which is none of OFF, LOCALHOST, SUBNET, SYSTEM_DEFAULT");
  }
  discovery.localhost_only = range == "LOCALHOST";
  discovery.peers = split(text_of_variable(static_peers));
  return discovery;
}

}  // namespace sft::core
