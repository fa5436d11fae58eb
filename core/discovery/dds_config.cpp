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

constexpr std::string_view own_domain_number = "Discovery/ExternalDomainId";

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

std::string element(std::string_view name, std::string_view content) {
  return "<" + std::string(name) + ">" + std::string(content) + "</" + std::string(name) + ">";
}

std::string document(std::string_view content) {
  return "<CycloneDDS><Domain id=\"any\">" + std::string(content) + "</Domain></CycloneDDS>";
}

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
  return element(setting.section, element(setting.name, setting.value));
}

std::string loopback_ports(bool finds_by_unicast) {
  const auto offsets = [](const std::string& cast, int first) {
    return element(cast + "MetaOffset", std::to_string(first)) +
           element(cast + "DataOffset", std::to_string(first + 1));
  };
  return offsets("Multicast", loopback_multicast_offset) +
         (finds_by_unicast ? offsets("Unicast", loopback_port_offset) : "");
}

bool has_name(const std::vector<std::string>& peers) {
  return std::ranges::any_of(peers, [](const auto& peer) { return name_in(peer).has_value(); });
}

bool chooses_interfaces(const CycloneSettings& user) {
  return user.sets("General/Interfaces") || user.sets("General/NetworkInterfaceAddress");
}

/// Returns the user's peers. One `Address` element of Cyclone's configuration may list several peers.
std::vector<std::string> peers_of(const CycloneSettings& user) {
  std::vector<std::string> peers;
  for (const std::string& listed : user.values("Discovery/Peers/Peer/@Address"))
    std::ranges::move(split(listed), std::back_inserter(peers));
  return peers;
}

/// Returns the user's configuration, unchanged if possible. Its interfaces and its domain number are left
/// out, because text_for() writes these for each link. Peers are left out, too, if one of them is a name,
/// because Cyclone would look it up.
std::string passed_through(const std::string& user_config, const CycloneSettings& user,
                           bool leaves_out_peers) {
  const bool suffices = !chooses_interfaces(user) && !user.sets(own_domain_number) &&
                        !user.depends_on_domain() && !leaves_out_peers;
  if (suffices) return user_config;
  std::vector<std::string_view> left_out{"General/Interfaces", "General/NetworkInterfaceAddress",
                                         own_domain_number};
  if (leaves_out_peers) left_out.emplace_back("Discovery/Peers");
  return user.for_any_domain(left_out);
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

/// Messages, and fragments of samples, fit into packets of 1280 bytes. The
/// kernel would divide a longer message into packets of the size that this host's interface allows. Some
/// tunnels drop such packets without an error, and then nodes would not find each other.
constexpr std::string_view message_max = "1232 B", fragment_max = "1100 B";

/// Returns SFT's own settings. A peer is asked at every port that a node on its host may have, each time.
/// So peers are asked rarely, and at few ports.
std::string settings_of_sft(const std::string& multicast, bool asks_peers) {
  const auto lease = asks_peers ? usual_times.cyclone_lease_to_peers : usual_times.cyclone_lease;
  std::string discovery =
      element("SPDPInterval", in_cyclone(lease * 3 / 4)) + element("LeaseDuration", in_cyclone(lease));
  if (asks_peers) discovery += element("ParticipantIndex", "auto") + element("MaxAutoParticipantIndex", "20");
  const std::string general = element("AllowMulticast", multicast) + element("MaxMessageSize", message_max) +
                              element("MaxRexmitMessageSize", message_max) +
                              element("FragmentSize", fragment_max);
  return document(element("General", general) + element("Discovery", discovery) +
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
                                    const CycloneSettings& user, bool has_peers) {
  std::vector<std::string> remarks;
  if (user.only_for_others())
    remarks.emplace_back("nothing in CYCLONEDDS_URI is for this domain, only for others");
  if (config.is_secured)
    remarks.emplace_back("DDS Security protects discovery and requests, not the samples");
  if (!settings.interfaces.empty() && chooses_interfaces(user))
    remarks.emplace_back("CYCLONEDDS_URI chooses the network interfaces, not DiscoverySettings::interfaces");
  if (!config.found_by_multicast && !has_peers)
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
  const bool has_peers = !settings.peers.empty() || user->sets("Discovery/Peers");
  // With configured peers, multicast serves discovery only: multicast might not reach those peers, so all
  // other data are sent to them by unicast.
  const std::string ours = !settings.multicast ? "false" : has_peers ? "spdp" : "default";
  const std::string multicast = user->value("General/AllowMulticast").value_or(ours);

  DdsConfig config;
  config.domain_on_wire = user->value(own_domain_number).value_or("default");
  if (equals(config.domain_on_wire, "default")) config.domain_on_wire = std::to_string(domain);
  config.found_by_multicast = !equals(multicast, "false");
  config.is_secured = user->sets("Security");
  config.heartbeat_port = heartbeat_port_of(config, *user, multicast);
  config.peers = settings.peers;
  config.user_peers = peers_of(*user);
  config.text_has_user_peers = !has_name(config.user_peers);
  config.interfaces = chosen_interfaces(*user, settings);
  const bool has_no_port = equals(user->value("Discovery/ParticipantIndex").value_or(""), "none");
  config.warnings = remarks_on(config, settings, *user, has_peers);
  std::string insisted;
  for (const Required& setting : required) insisted += insist_on(setting, *user, config.warnings);
  if (has_no_port && !config.found_by_multicast)
    insisted += insist_on(predictable_port, *user, config.warnings);
  // A later setting overrides an earlier one.
  const std::string users = passed_through(user_config, *user, !config.text_has_user_peers);
  config.text = settings_of_sft(ours, !config.found_by_multicast || has_peers) + "," +
                (users.empty() ? "" : users + ",") + document(insisted);
  return config;
}

/// Participants with an index are few where peers are asked, and ROS 2's nodes need one each. This one has
/// none: it asks the peers, and they answer.
static std::string settings_of_ros(const RosDiscovery& ros) {
  if (ros.loopback_only) return "<General><Interfaces><NetworkInterface address=\"127.0.0.1\"/></></>";
  std::string peers = ros.localhost_only ? "<Peer address=\"localhost\"/>" : "";
  for (const std::string& peer : ros.peers) peers += "<Peer address=\"" + peer + "\"/>";
  if (peers.empty()) return {};
  return (ros.localhost_only ? "<General><AllowMulticast>false</></>" : "") +
         element("Discovery",
                 "<ParticipantIndex>none</><MaxAutoParticipantIndex>32</>" + element("Peers", peers));
}

/// Multicasts of samples would reach the ports of all links of this network. The one setting that SFT cannot
/// do without concerns the runtime of iceoryx, of which a process has one.
Result<VanillaConfig> vanilla_config(std::uint32_t domain, const std::string& user_config,
                                     const RosDiscovery& ros) {
  const Result<CycloneSettings> user = CycloneSettings::read(user_config, domain);
  if (!user) return tl::unexpected(user.error());
  const bool suffices = !user->sets(own_domain_number) && !user->depends_on_domain();
  const std::string users = suffices ? user_config : user->for_any_domain({own_domain_number});
  std::string on_wire = user->value(own_domain_number).value_or("default");
  if (equals(on_wire, "default")) on_wire = std::to_string(domain);
  constexpr std::string_view ours =
      "<General><AllowMulticast>spdp</></><Sizing><ReceiveBufferSize>256 KiB</></>"
      "<Internal><MultipleReceiveThreads>false</><WriterLingerDuration>0 s</></>";
  const std::string insisted = element("SharedMemory", element("Enable", "false")) +
                               element("Discovery", element("ExternalDomainId", on_wire));
  const std::string of_ros = settings_of_ros(ros);
  return VanillaConfig{.text = document(ours) + "," + (of_ros.empty() ? "" : document(of_ros) + ",") +
                               (users.empty() ? "" : users + ",") + document(insisted),
                       .is_secured = user->sets("Security")};
}

std::string DdsConfig::summary(std::span<const LinkSpec> links) const {
  std::vector<std::string> asked = peers;
  asked.insert(asked.end(), user_peers.begin(), user_peers.end());
  const std::string on_peers = asked.empty() ? "" : ", and on the peers " + list(asked);
  return found_by_multicast ? "by multicast on " + describe(links) + on_peers
                            : "on this host" + on_peers + ", by " + describe(links);
}

std::optional<IpFamily> DdsConfig::family_of_peers(std::span<const LinkSpec> links) const {
  const auto asks = [&](const LinkSpec& link) { return !link.loopback || !text_has_user_peers; };
  const auto link = std::ranges::find_if(links, asks);
  return link == links.end() ? std::nullopt : std::optional(family_on(*link));
}

/// Datagrams from any interface may arrive at a port of this host. Without DontRoute, each link would also
/// send to addresses outside its network. With peers, DontRoute is not set, since peers may be reachable
/// only through a router. Nodes of one host find each other on the loopback. Multicasts of other links are
/// not looped back to the host, since nodes of this host would otherwise find each other a second time.
std::string DdsConfig::text_for(const LinkSpec& link, const KnownHosts& hosts) const {
  const std::string which = link.ip.is_any() ? "name=\"" + link.interface : "address=\"" + format(link.ip);
  std::string general = element(
      "Interfaces", "<NetworkInterface " + which + (link.loopback ? "\" multicast=\"true\"/>" : "\"/>"));
  if (link.ip.is_any()) general += element("Transport", "udp6");
  if (!rules().peers) general += element("DontRoute", "true");
  if (!link.reaches_own_host) general += element("EnableMulticastLoopback", "false");
  std::string discovery = element("ExternalDomainId", domain_on_wire);
  std::string asked;
  const auto ask = [&](const std::vector<std::string>& these) {
    for (const std::string& peer : these) {
      for (const std::string& number : in_numbers(peer, family_on(link), hosts))
        asked += "<Peer Address=\"" + number + "\"/>";
    }
  };
  if (!found_by_multicast && link.reaches_own_host) ask({format(loopback_ipv4), format(loopback_ipv6)});
  if (!link.loopback) ask(peers);
  if (!text_has_user_peers) ask(user_peers);
  if (!asked.empty()) discovery += element("Peers", asked);
  if (link.loopback) discovery += element("Ports", loopback_ports(!found_by_multicast || rules().peers));
  return text + "," + document(element("General", general) + element("Discovery", discovery));
}

Result<std::vector<std::string>> discovery_interfaces(std::uint32_t domain, const DiscoverySettings& settings,
                                                      const std::string& user_config) {
  return CycloneSettings::read(user_config, domain).map([&](const CycloneSettings& user) {
    return chosen_interfaces(user, settings);
  });
}

}  // namespace sft::core
