#include "tools/sft/dds_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <string_view>

#include "core/platform/text_file.h"
#include "tools/terminal/units.h"

namespace sft::tool {

namespace {

std::string variable(const char* name) {
  const char* const value = std::getenv(name);
  return value == nullptr ? "" : value;
}

/// Returns the text of CYCLONEDDS_URI, or that of the file that it names.
std::string config_text(std::string uri) {
  constexpr std::string_view scheme = "file://";
  if (uri.empty() || uri.find('<') != uri.npos) return uri;
  return core::read_text_file(uri.starts_with(scheme) ? uri.substr(scheme.size()) : uri).value_or("");
}

/// Returns true if Fast DDS uses UDP with this value of FASTDDS_BUILTIN_TRANSPORTS.
bool speaks_udp(std::string_view transports) {
  constexpr std::array<std::string_view, 5> with_udp{"", "DEFAULT", "DEFAULTv6", "UDPv4", "UDPv6"};
  return std::ranges::find(with_udp, transports) != with_udp.end();
}

bool speaks_dds(std::string_view middleware) {
  constexpr std::array<std::string_view, 5> of_dds{"rmw_cyclonedds", "rmw_fastrtps", "rmw_fastdds",
                                                   "rmw_connextdds", "rmw_gurumdds"};
  return middleware.empty() ||
         std::ranges::any_of(of_dds, [&](std::string_view one) { return middleware.starts_with(one); });
}

Finding warning(std::string text, std::string to_do) {
  return {"dds", Health::warning, std::move(text), std::move(to_do)};
}

std::string setting(const char* name, const std::string& value) {
  return fmt::format("{} is '{}': nodes of DDS with this setting ", name, value);
}

std::vector<Finding> check_environment(const DdsEnvironment& environment) {
  std::vector<Finding> findings;
  if (!environment.discovery_server.empty()) {
    findings.push_back(
        warning(setting("ROS_DISCOVERY_SERVER", environment.discovery_server) +
                    "find each other by a server of Fast DDS, and neither find SFT nor are found by it",
                "Unset it for nodes that are to share topics with SFT."));
  }
  if (!speaks_udp(environment.transports)) {
    findings.push_back(warning(setting("FASTDDS_BUILTIN_TRANSPORTS", environment.transports) +
                                   "do not send and receive all by UDP, by which SFT reaches them",
                               "Set it to DEFAULT or UDPv4 for them."));
  }
  if (environment.security == "true") {
    findings.push_back(
        warning(setting("ROS_SECURITY_ENABLE", environment.security) +
                    "are in a secured enclave, and ignore nodes without DDS Security, as SFT's",
                "Unset it for nodes that are to share topics with SFT."));
  }
  if (!speaks_dds(environment.middleware)) {
    findings.push_back(warning(
        fmt::format("RMW_IMPLEMENTATION is '{}': nodes of ROS 2 with this setting do not speak DDS",
                    environment.middleware),
        "Set it to rmw_cyclonedds_cpp or rmw_fastrtps_cpp for nodes that are to share topics with SFT."));
  }
  if (environment.cyclone_config.find("<Tag>") != std::string::npos) {
    findings.push_back(
        warning("CYCLONEDDS_URI sets a tag of discovery (Discovery/Tag): only nodes of DDS with the same tag "
                "are found",
                "Remove it, or set it for all nodes that are to share topics."));
  }
  if (environment.range == "OFF") {
    findings.push_back(
        warning("ROS_AUTOMATIC_DISCOVERY_RANGE is 'OFF': no node of DDS is looked for or found",
                "Set it to SUBNET or LOCALHOST."));
  }
  return findings;
}

std::string name_of(const DomainSnapshot::DdsNode& node) {
  std::string more = node.process;
  if (!node.host.empty()) more += (more.empty() ? "on " : " on ") + node.host;
  return more.empty() ? node.name : node.name + ", " + more + ",";
}

Finding nodes_of(const DomainSnapshot& domain) {
  const auto is_dds = [](const DomainSnapshot::Endpoint& e) { return e.dds.has_value(); };
  const auto writers = std::ranges::count_if(domain.publishers, is_dds);
  const auto readers = std::ranges::count_if(domain.subscribers, is_dds);
  if (domain.dds_nodes.empty()) return {"dds", Health::ok, "no node of DDS is found that is not one of SFT"};
  return {"dds", Health::ok,
          fmt::format("{} that know nothing of SFT, with {} and {} of topics that SFT can share",
                      count_text(domain.dds_nodes.size(), "DDS node"),
                      count_text(static_cast<std::uint64_t>(writers), "writer"),
                      count_text(static_cast<std::uint64_t>(readers), "reader"))};
}

}  // namespace

DdsEnvironment DdsEnvironment::of_process() {
  return {.discovery_server = variable("ROS_DISCOVERY_SERVER"),
          .transports = variable("FASTDDS_BUILTIN_TRANSPORTS"),
          .security = variable("ROS_SECURITY_ENABLE"),
          .middleware = variable("RMW_IMPLEMENTATION"),
          .range = variable("ROS_AUTOMATIC_DISCOVERY_RANGE"),
          .cyclone_config = config_text(variable("CYCLONEDDS_URI"))};
}

std::vector<Finding> check_dds(const DdsEnvironment& environment, const DomainSnapshot& domain) {
  std::vector<Finding> findings = check_environment(environment);
  for (const DomainSnapshot::DdsNode& node : domain.dds_nodes) {
    if (node.endpoints > 0) continue;
    findings.push_back(
        warning(fmt::format("{} is heard, and has announced no reader and no writer: it has none, or its "
                            "answers do not arrive",
                            name_of(node)),
                "Let UDP pass the firewalls of both hosts: DDS uses the ports from 7400 + 250 x domain."));
  }
  findings.push_back(nodes_of(domain));
  return findings;
}

bool all_dds_nodes_have_answered(const DomainSnapshot& domain) {
  return std::ranges::none_of(domain.dds_nodes,
                              [](const DomainSnapshot::DdsNode& node) { return node.endpoints == 0; });
}

}  // namespace sft::tool
