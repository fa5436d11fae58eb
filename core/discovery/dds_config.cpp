#include "core/discovery/dds_config.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <chrono>
#include <iterator>
#include <ranges>
#include <string_view>

#include "core/discovery/cyclone_settings.h"
#include "core/discovery/timing.h"
#include "core/platform/ip_address.h"

namespace sft::core {

namespace {

constexpr Timing usual_times;

/// A setting that SFT requires, whatever the user's configuration says.
struct Required {
  std::string_view section, name, value, why;
};
constexpr std::array required{
    Required{"SharedMemory", "Enable", "false",
             "Cyclone DDS and SFT cannot both use the one iceoryx runtime of a process"},
    Required{"General", "EnableMulticastLoopback", "true", "nodes of one host would not find each other"},
    Required{"Compatibility", "ManySocketsMode", "single", "nodes could not be reached"}};
constexpr Required predictable_port{
    "Discovery", "ParticipantIndex", "auto",
    "without multicast, nodes are looked for at the ports that DDS derives from the index"};

// The offset of the first port of nodes that find each other on the loopback without multicast. Because of
// the offset, these nodes do not use the first ports, of which there are few and which the other links
// need.
constexpr int loopback_port_offset = 120;

// Ports of multicasts on the loopback. Linux gives a multicast datagram to each socket that is bound to its
// port, whatever the interface (IP_MULTICAST_ALL, ip(7)). If the loopback used the ports of the other links,
// each of its multicasts would wake the threads of all links of each process. DDS itself leaves these two
// ports unused.
constexpr int loopback_multicast_offset = 2;

// Ports of a domain, as DDS prescribes them (RTPS 2.3, 9.6.1), and the offset of the port of heartbeats,
// which DDS leaves unused.
constexpr unsigned first_port = 7400, ports_of_domain = 250, heartbeat_offset = 4;
// Settings that change how multicasts are sent, or which nodes receive them. Heartbeats do not follow these
// settings, because Cyclone does not send them.
constexpr std::array<std::string_view, 6> changes_of_multicasts{
    "General/DontRoute",
    "General/MulticastRecvNetworkInterfaceAddresses",
    "General/MulticastTimeToLive",
    "Discovery/Ports",
    "Discovery/SPDPMulticastAddress",
    "Discovery/Tag"};

std::string in_cyclone(std::chrono::milliseconds time) { return std::to_string(time.count()) + " ms"; }

std::string list(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

/// Returns the parts of a text between commas.
std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> parts;
  for (const auto part : std::views::split(text, ',')) parts.emplace_back(part.begin(), part.end());
  return parts;
}

/// Returns the required setting as XML, and names a value of the user that does not hold.
std::string insist_on(const Required& setting, const CycloneSettings& user,
                      std::vector<std::string>& warnings) {
  const std::string path = std::string(setting.section) + "/" + std::string(setting.name);
  if (const auto value = user.value(path); value && !equals(*value, setting.value)) {
    warnings.push_back(path + " is '" + std::string(setting.value) + "', not '" + *value +
                       "' as CYCLONEDDS_URI says: " + std::string(setting.why));
  }
  return xml_element(setting.section, xml_element(setting.name, setting.value));
}

std::string loopback_ports(bool finds_by_unicast) {
  const auto offsets = [](const std::string& cast, int first) {
    return xml_element(cast + "MetaOffset", std::to_string(first)) +
           xml_element(cast + "DataOffset", std::to_string(first + 1));
  };
  return offsets("Multicast", loopback_multicast_offset) +
         (finds_by_unicast ? offsets("Unicast", loopback_port_offset) : "");
}

bool chooses_interfaces(const CycloneSettings& user) {
  return user.sets("General/Interfaces") || user.sets("General/NetworkInterfaceAddress");
}

/// Returns the peers of the settings and of the user. One `Address` element of Cyclone's configuration may
/// list several peers.
std::vector<std::string> all_peers(const DiscoverySettings& settings, const CycloneSettings& user) {
  std::vector<std::string> peers = settings.peers;
  for (const std::string& listed : user.values("Discovery/Peers/Peer/@Address"))
    std::ranges::move(split(listed), std::back_inserter(peers));
  return peers;
}

/// Acknowledgements without delay and early heartbeats make a newcomer's first request arrive within
/// milliseconds, or soon after that if datagrams get lost. Messages that are repeated while nothing happens
/// are kept rare. A link whose address is gone must not wait for acknowledgements when it is deleted.
///
/// Each heartbeat of a writer that is repeated for one newcomer asks all readers. So a reader that has
/// already acknowledged everything waits for `AckDelay` before it acknowledges again. Acknowledgements of
/// new samples and requests for missing ones are not delayed.
///
/// A domain stores received packets in its buffer one after the other, so in time it touches the memory of
/// the whole buffer. Control traffic does not need the usual 1 MiB.
constexpr std::string_view settings_of_all_links = R"(<Sizing><ReceiveBufferSize>256 KiB</></><Internal>
<PreEmptiveAckDelay>0 ms</><NackDelay>1 ms</><AckDelay>1 s</><HeartbeatInterval max="2 s">20 ms</>
<MultipleReceiveThreads>false</><WriterLingerDuration>0 s</></>)";

struct MessageSizes {
  std::string_view message, fragment;  ///< the maximum sizes of messages and of fragments of samples
};
/// Messages fit into packets of 1000 bytes, and with DDS Security into packets of 1200 bytes: certificates
/// make announcements of participants longer, and Cyclone cannot divide these. The kernel divides a message
/// if this host's interface, or a router that says so, allows only shorter packets. Some tunnels drop longer
/// packets without an error, and then nodes would not find each other.
constexpr MessageSizes usual_sizes{"972 B", "840 B"}, secured_sizes{"1152 B", "1020 B"};

/// Returns SFT's own settings. A peer is asked at every port that a node on its host may have, each time.
/// So peers are asked rarely, and at few ports.
std::string settings_of_sft(const std::string& multicast, bool asks_peers, const MessageSizes& sizes) {
  const auto lease = asks_peers ? usual_times.cyclone_lease_to_peers : usual_times.cyclone_lease;
  std::string discovery = xml_element("SPDPInterval", in_cyclone(lease * 3 / 4)) +
                          xml_element("LeaseDuration", in_cyclone(lease));
  if (asks_peers)
    discovery += xml_element("ParticipantIndex", "auto") + xml_element("MaxAutoParticipantIndex", "20");
  const std::string general =
      xml_element("AllowMulticast", multicast) + xml_element("MaxMessageSize", sizes.message) +
      xml_element("MaxRexmitMessageSize", sizes.message) + xml_element("FragmentSize", sizes.fragment);
  return xml_document(xml_element("General", general) + xml_element("Discovery", discovery) +
                      std::string(settings_of_all_links));
}

/// `multicast`: the value of General/AllowMulticast.
std::optional<std::uint16_t> heartbeat_port_of(const DdsConfig& config, const CycloneSettings& user,
                                               std::string_view multicast) {
  const auto is_set = [&](std::string_view path) { return user.sets(path); };
  unsigned number = 0;
  const std::string& domain = config.domain_on_wire;
  const auto read = std::from_chars(domain.data(), domain.data() + domain.size(), number);
  const bool has_ports = read.ec == std::errc{} && number <= NodeOptions::domain_max;
  const bool has_none = equals(multicast, "false") || equals(multicast, "spdp") || equals(multicast, "ssm");
  if (!has_ports || has_none || config.is_secured || std::ranges::any_of(changes_of_multicasts, is_set))
    return std::nullopt;
  return static_cast<std::uint16_t>(first_port + ports_of_domain * number + heartbeat_offset);
}

std::vector<std::string> remarks_on(const DdsConfig& config, const DiscoverySettings& settings,
                                    const CycloneSettings& user) {
  std::vector<std::string> remarks;
  if (user.only_for_others())
    remarks.emplace_back("nothing in CYCLONEDDS_URI is for this domain, only for others");
  if (config.is_secured)
    remarks.emplace_back("DDS Security protects discovery and requests, not the samples");
  if (!settings.interfaces.empty() && chooses_interfaces(user))
    remarks.emplace_back("CYCLONEDDS_URI chooses the network interfaces, not DiscoverySettings::interfaces");
  if (!config.found_by_multicast && config.peers.empty())
    remarks.emplace_back("multicast is off and there are no peers: only nodes of this host are found");
  return remarks;
}

IpFamily family_on(const LinkSpec& link) { return link.ip.is_any() ? IpFamily::ipv6 : IpFamily::ipv4; }

Result<void> check_names(const std::vector<std::string>& names, const char* what) {
  const auto is_plain = [](const std::string& name) {
    return !name.empty() && std::ranges::all_of(name, [](unsigned char c) {
      return std::isalnum(c) != 0 ||
             std::string_view(".:-_[]%@/").find(static_cast<char>(c)) != std::string_view::npos;
    });
  };
  for (const std::string& name : names) {
    if (is_plain(name)) continue;
    return fail(Errc::invalid_argument, std::string("DiscoverySettings::") + what + ": '" + name +
                                            "' is not the name or address of " +
                                            (what == std::string_view("peers") ? "a host" : "an interface"));
  }
  return {};
}

/// Returns the names of the interfaces that the user's configuration or the settings choose. An empty list
/// excludes no interface; it is returned if the configuration lets Cyclone choose.
std::vector<std::string> chosen_interfaces(const CycloneSettings& user, const DiscoverySettings& settings) {
  if (!chooses_interfaces(user)) return settings.interfaces;
  const std::vector<std::string> any = user.values("General/Interfaces/NetworkInterface/@autodetermine");
  if (std::ranges::any_of(any, [](const std::string& value) { return equals(value, "true"); })) return {};
  std::vector<std::string> names = user.values("General/Interfaces/NetworkInterface/@name");
  std::ranges::move(user.values("General/Interfaces/NetworkInterface/@address"), std::back_inserter(names));
  const auto deprecated = user.value("General/NetworkInterfaceAddress");
  std::ranges::move(split(deprecated.value_or("")), std::back_inserter(names));
  std::erase_if(names, [](const std::string& name) { return equals(name, "auto") || name.empty(); });
  return names;
}

}  // namespace

Result<DdsConfig> dds_config(std::uint32_t domain, const DiscoverySettings& settings,
                             const std::string& user_config) {
  if (const auto ok = check_names(settings.peers, "peers"); !ok) return tl::unexpected(ok.error());
  if (const auto ok = check_names(settings.interfaces, "interfaces"); !ok) return tl::unexpected(ok.error());
  const Result<CycloneSettings> user = CycloneSettings::read(user_config, domain);
  if (!user) return tl::unexpected(user.error());
  DdsConfig config;
  config.peers = all_peers(settings, *user);
  // With configured peers, multicast serves discovery only: multicast might not reach those peers, so all
  // other data are sent to them by unicast.
  const std::string ours = !settings.multicast ? "false" : !config.peers.empty() ? "spdp" : "default";
  const std::string multicast = user->value("General/AllowMulticast").value_or(ours);

  config.domain_on_wire = user->domain_on_wire();
  config.found_by_multicast = !equals(multicast, "false");
  config.is_secured = user->is_secured();
  config.heartbeat_port = heartbeat_port_of(config, *user, multicast);
  config.interfaces = chosen_interfaces(*user, settings);
  const bool has_no_port = equals(user->value("Discovery/ParticipantIndex").value_or(""), "none");
  config.warnings = remarks_on(config, settings, *user);
  std::string insisted;
  for (const Required& setting : required) insisted += insist_on(setting, *user, config.warnings);
  if (has_no_port && !config.found_by_multicast)
    insisted += insist_on(predictable_port, *user, config.warnings);
  // text_for() writes these for each link, peers as numbers, because Cyclone would look up names. A later
  // setting overrides an earlier one.
  const std::string users = user->for_any_domain(
      {"General/Interfaces", "General/NetworkInterfaceAddress", "Discovery/Peers", domain_number_path});
  config.text = settings_of_sft(ours, !config.found_by_multicast || !config.peers.empty(),
                                config.is_secured ? secured_sizes : usual_sizes) +
                "," + (users.empty() ? "" : users + ",") + xml_document(insisted);
  return config;
}

std::string DdsConfig::summary(std::span<const LinkSpec> links) const {
  const std::string on_peers = peers.empty() ? "" : ", and on the peers " + list(peers);
  return found_by_multicast ? "by multicast on " + describe(links) + on_peers
                            : "on this host" + on_peers + ", by " + describe(links);
}

std::optional<IpFamily> DdsConfig::family_of_peers(std::span<const LinkSpec> links) const {
  const auto link = std::ranges::find(links, false, &LinkSpec::loopback);
  return link == links.end() ? std::nullopt : std::optional(family_on(*link));
}

/// Datagrams from any interface may arrive at a port of this host. Without DontRoute, each link would also
/// send to addresses outside its network. With peers, DontRoute is not set, since peers may be reachable
/// only through a router. Nodes of one host find each other on the loopback. Multicasts of other links are
/// not looped back to the host, since nodes of this host would otherwise find each other a second time.
std::string DdsConfig::text_for(const LinkSpec& link, const KnownHosts& hosts) const {
  const std::string which = link.ip.is_any() ? "name=\"" + link.interface : "address=\"" + format(link.ip);
  std::string general = xml_element(
      "Interfaces", "<NetworkInterface " + which + (link.loopback ? "\" multicast=\"true\"/>" : "\"/>"));
  if (link.ip.is_any()) general += xml_element("Transport", "udp6");
  if (!rules().peers) general += xml_element("DontRoute", "true");
  if (!link.reaches_own_host) general += xml_element("EnableMulticastLoopback", "false");
  std::string discovery = xml_element("ExternalDomainId", domain_on_wire);
  std::string asked;
  const auto ask = [&](const std::vector<std::string>& these) {
    for (const std::string& peer : these) {
      for (const std::string& number : in_numbers(peer, family_on(link), hosts))
        asked += "<Peer Address=\"" + number + "\"/>";
    }
  };
  if (!found_by_multicast && link.reaches_own_host) ask({format(loopback_ipv4), format(loopback_ipv6)});
  if (!link.loopback) ask(peers);
  if (!asked.empty()) discovery += xml_element("Peers", asked);
  if (link.loopback) discovery += xml_element("Ports", loopback_ports(!found_by_multicast || rules().peers));
  return text + "," + xml_document(xml_element("General", general) + xml_element("Discovery", discovery));
}

Result<std::vector<std::string>> discovery_interfaces(std::uint32_t domain, const DiscoverySettings& settings,
                                                      const std::string& user_config) {
  return CycloneSettings::read(user_config, domain).map([&](const CycloneSettings& user) {
    return chosen_interfaces(user, settings);
  });
}

}  // namespace sft::core
