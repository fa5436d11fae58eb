#include "core/discovery/dds_config.h"

#include <fnmatch.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <optional>
#include <ranges>
#include <string_view>

#include "core/discovery/cyclone_settings.h"
#include "core/platform/ip_address.h"

namespace sft::core {

namespace {

constexpr std::array control_topics{"sft_writer", "sft_reader", "sft_heartbeat", "sft_report"};
constexpr std::size_t fragment_bytes_min = 128;
constexpr std::size_t sample_bytes_min = 131'072;  // of control samples; the largest have some 96,000

std::string element(std::string_view name, std::string_view content) {
  return "<" + std::string(name) + ">" + std::string(content) + "</" + std::string(name) + ">";
}

std::string document(std::string_view content) {
  return "<CycloneDDS><Domain id=\"any\">" + std::string(content) + "</Domain></CycloneDDS>";
}

std::string list(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

/// "8 kB", as Cyclone writes sizes; malformed ones it refuses itself.
double bytes_of(std::string_view text) {
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{}) return sample_bytes_min;
  std::string_view unit(end, text.data() + text.size());
  unit.remove_prefix(std::min(unit.find_first_not_of(' '), unit.size()));
  switch (unit.empty() ? 'b' : std::tolower(static_cast<unsigned char>(unit[0]))) {
    case 'k':
      return number * 1024;
    case 'm':
      return number * 1024 * 1024;
    case 'g':
      return number * 1024 * 1024 * 1024;
    default:
      return number;
  }
}

/// A setting that SFT cannot do without, though the user may have set it otherwise.
struct Demand {
  std::string_view group;
  std::string_view name;
  bool (*breaks_sft)(const std::string& value);
  std::string_view instead;
  std::string_view why;
};

constexpr std::array demands{
    Demand{"SharedMemory", "Enable", [](const std::string& v) { return !equals(v, "false"); }, "false",
           "Cyclone DDS and SFT cannot both use the one iceoryx runtime of a process"},
    Demand{"General", "EnableMulticastLoopback", [](const std::string& v) { return equals(v, "false"); },
           "true", "nodes of one host would not find each other"},
    Demand{"General", "FragmentSize", [](const std::string& v) { return bytes_of(v) < fragment_bytes_min; },
           "1344 B", "announcements would not get through, or in hundreds of datagrams"},
    Demand{"Internal", "MaxSampleSize", [](const std::string& v) { return bytes_of(v) < sample_bytes_min; },
           "2147483647 B", "announcements with the description of a type may have 128 kB"},
    Demand{"Compatibility", "ManySocketsMode",
           [](const std::string& v) { return equals(v, "none") || equals(v, "false"); }, "single",
           "nodes could not be reached"},
};

constexpr std::string_view own_domain_number = "Discovery/ExternalDomainId";

// The first port of nodes that look for each other without multicast on the loopback. It lies beside the
// ports of the other links, which would otherwise take the first ones, of which there are few.
constexpr int loopback_port_offset = 120;

// Ports of multicasts on the loopback. Linux gives a multicast datagram to each socket that is bound to its
// port, whatever the interface (IP_MULTICAST_ALL, ip(7)). With the ports of the other links, each sign of
// life would wake the threads of all links of each process. DDS itself leaves these two ports unused.
constexpr int loopback_multicast_offset = 2;

// Ports of a domain, as DDS prescribes them (RTPS 2.3, 9.6.1), and the port of heartbeats among those that it
// leaves unused.
constexpr unsigned first_port = 7400, ports_of_domain = 250, heartbeat_offset = 4;
constexpr std::array<std::string_view, 5> changes_of_multicasts{
    "General/DontRoute", "General/MulticastRecvNetworkInterfaceAddresses", "General/MulticastTimeToLive",
    "Discovery/Ports", "Discovery/SPDPMulticastAddress"};

std::string loopback_ports(bool finds_by_unicast) {
  const auto offsets = [](const std::string& cast, int first) {
    return element(cast + "MetaOffset", std::to_string(first)) +
           element(cast + "DataOffset", std::to_string(first + 1));
  };
  return offsets("Multicast", loopback_multicast_offset) +
         (finds_by_unicast ? offsets("Unicast", loopback_port_offset) : "");
}

constexpr Demand predictable_port{
    "Discovery", "ParticipantIndex", [](const std::string& v) { return equals(v, "none"); }, "auto",
    "without multicast, nodes are looked for at the ports that DDS derives from the index"};

std::string path_of(const Demand& demand) {
  return std::string(demand.group) + "/" + std::string(demand.name);
}

// Our settings of the lease after which Cyclone forgets a participant of which nothing comes.
constexpr std::chrono::seconds usual_lease{40}, lease_if_asked_seldom{150};

/// The settings of a domain, put together.
class Composition {
 public:
  Composition(const DiscoverySettings& settings, const CycloneSettings& user)
      : settings_(settings),
        user_(user),
        multicast_(user.value("General/AllowMulticast").value_or(multicast_by_ours())) {}

  DdsConfig result(std::uint32_t domain, const std::string& user_config) const {
    DdsConfig config;
    config.domain_on_wire = user_.value(own_domain_number).value_or("default");
    if (equals(config.domain_on_wire, "default")) config.domain_on_wire = std::to_string(domain);
    config.multicast = !finds_by_peers_only() && !equals(multicast_, "spdp");
    config.found_by_multicast = !finds_by_peers_only();
    config.participant_lease = asks_seldom() ? lease_if_asked_seldom : usual_lease;
    config.is_secured = user_.sets("Security");
    config.heartbeat_port = heartbeat_port(config);
    config.peers = settings_.peers;
    config.user_peers = user_peers();
    config.text_has_user_peers = !has_peer_by_name();
    std::string insisted;
    for (const Demand& demand : demands) insisted += insist_on(demand, config.warnings);
    if (finds_by_peers_only()) insisted += insist_on(predictable_port, config.warnings);
    // A later setting wins over an earlier one.
    const std::string users = of_user(user_config);
    config.text = ours() + "," + (users.empty() ? "" : users + ",") + document(insisted);
    add_remarks(config.warnings);
    return config;
  }

 private:
  /// What the user has changed of how multicasts go may matter to heartbeats, too, which Cyclone does not send.
  std::optional<std::uint16_t> heartbeat_port(const DdsConfig& config) const {
    const bool is_as_usual =
        std::ranges::none_of(changes_of_multicasts, [&](std::string_view path) { return user_.sets(path); });
    unsigned number = 0;
    const std::string& domain = config.domain_on_wire;
    const auto read = std::from_chars(domain.data(), domain.data() + domain.size(), number);
    const bool has_ports = read.ec == std::errc{} && number <= NodeOptions::domain_max;
    const bool has_multicast = config.multicast && !equals(multicast_, "ssm");
    if (!is_as_usual || !has_ports || !has_multicast || config.is_secured) return std::nullopt;
    return static_cast<std::uint16_t>(first_port + ports_of_domain * number + heartbeat_offset);
  }

  /// To peers that it does not reach, nothing must go by it once they are found.
  std::string multicast_by_ours() const {
    if (!settings_.multicast) return "false";
    return has_peers() ? "spdp" : "default";
  }
  bool finds_by_peers_only() const { return equals(multicast_, "false"); }
  bool has_peers() const { return !settings_.peers.empty() || user_.sets("Discovery/Peers"); }
  /// One `Address` of Cyclone's configuration may list several peers, separated by commas.
  std::vector<std::string> user_peers() const {
    std::vector<std::string> peers;
    for (const std::string& value : user_.values("Discovery/Peers/Peer/@Address")) {
      for (const auto peer : std::views::split(value, ',')) peers.emplace_back(peer.begin(), peer.end());
    }
    return peers;
  }
  bool has_peer_by_name() const {
    return std::ranges::any_of(user_peers(), [](const auto& peer) { return name_in(peer).has_value(); });
  }
  bool user_chose_interfaces() const {
    return user_.sets("General/Interfaces") || user_.sets("General/NetworkInterfaceAddress");
  }
  /// Each link has its interface, and all have the domain number of the network: the user's choice of these
  /// is applied to the links, and taken out here. Peers are taken out, too, if one of them is a name: Cyclone
  /// would look it up.
  std::string of_user(const std::string& user_config) const {
    const bool by_name = has_peer_by_name();
    const bool as_it_is =
        !user_chose_interfaces() && !user_.sets(own_domain_number) && !user_.depends_on_domain() && !by_name;
    if (as_it_is) return user_config;
    std::vector<std::string_view> left_out{"General/Interfaces", "General/NetworkInterfaceAddress",
                                           own_domain_number};
    if (by_name) left_out.emplace_back("Discovery/Peers");
    return user_.for_any_domain(left_out);
  }

  /// Acknowledgements that do not wait and heartbeats that come at once make a newcomer's first request
  /// arrive within milliseconds, and soon where datagrams get lost; what repeats while nothing happens is
  /// kept rare. A link whose address is gone must not wait for acknowledgements when it is deleted.
  ///
  /// Each heartbeat that is repeated for one newcomer asks everybody, so a reader that has told already that
  /// it has everything waits for `AckDelay` before it tells so again. News and gaps do not wait for that.
  ///
  /// What comes is put into one receive buffer behind the other, and so each of a node's domains touches all
  /// of a buffer in the end. Control traffic does not need the usual 1 MiB.
  std::string ours() const {
    return document(
        element("General", element("AllowMulticast", multicast_by_ours())) +
        element("Discovery", discovery()) + element("Sizing", element("ReceiveBufferSize", "256 KiB")) +
        element("Internal",
                element("PreEmptiveAckDelay", "0 ms") + element("NackDelay", "1 ms") +
                    element("AckDelay", "1 s") + "<HeartbeatInterval max=\"2 s\">20 ms</HeartbeatInterval>" +
                    element("MultipleReceiveThreads", "false") + element("WriterLingerDuration", "0 s")));
  }

  bool asks_seldom() const { return finds_by_peers_only() || has_peers(); }

  /// A newcomer is answered at once, and greetings repeat what may have got lost (greetings.h): Cyclone's own
  /// announcements, which are much of what idle nodes send, may be rare. A peer is asked at every port that a
  /// node of it may have, each time: that has to be rarer still, and they few.
  std::string discovery() const {
    if (!asks_seldom())
      return element("SPDPInterval", "30 s") +
             element("LeaseDuration", std::to_string(usual_lease.count()) + " s");
    return element("SPDPInterval", "120 s") +
           element("LeaseDuration", std::to_string(lease_if_asked_seldom.count()) + " s") +
           element("ParticipantIndex", "auto") + element("MaxAutoParticipantIndex", "20");
  }

  /// Also where the user sets nothing, or nothing that could be found. Empty where the user's value will do.
  std::string insist_on(const Demand& demand, std::vector<std::string>& warnings) const {
    const auto value = user_.value(path_of(demand));
    if (value && !demand.breaks_sft(*value)) return "";
    if (value) {
      warnings.push_back(path_of(demand) + " is '" + std::string(demand.instead) + "', not '" + *value +
                         "' as CYCLONEDDS_URI says: " + std::string(demand.why));
    }
    return element(demand.group, element(demand.name, demand.instead));
  }

  void add_remarks(std::vector<std::string>& warnings) const {
    if (user_.only_for_others()) {
      warnings.emplace_back("nothing in CYCLONEDDS_URI is for this domain, only for others");
    }
    if (user_.sets("Security")) {
      warnings.emplace_back("DDS Security protects who finds whom and who asks for what, not the samples");
    }
    if (!settings_.interfaces.empty() && user_chose_interfaces()) {
      warnings.emplace_back(
          "CYCLONEDDS_URI chooses the network interfaces, not DiscoverySettings::interfaces");
    }
    if (finds_by_peers_only() && !has_peers()) {
      warnings.emplace_back("multicast is off and there are no peers: only nodes of this host are found");
    }
  }

  const DiscoverySettings& settings_;
  const CycloneSettings& user_;
  const std::string multicast_;  ///< in force, of Cyclone's AllowMulticast
};

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

/// Partitions cannot be taken off the list that they are on.
Result<void> check_partitions(const CycloneSettings& user) {
  for (const std::string& pattern :
       user.values("Partitioning/IgnoredPartitions/IgnoredPartition/@DCPSPartitionTopic")) {
    for (const char* topic : control_topics) {
      if (fnmatch(pattern.c_str(), (std::string(".") + topic).c_str(), 0) != 0) continue;
      return fail(Errc::invalid_argument, "CYCLONEDDS_URI: the ignored partition '" + pattern +
                                              "' holds SFT's control topic " + topic + ": take it out");
    }
  }
  return {};
}

/// No interface is excluded if Cyclone is to choose by itself.
std::vector<std::string> chosen_interfaces(const CycloneSettings& user, const DiscoverySettings& settings) {
  std::vector<std::string> names;
  for (const char* attribute : {"@name", "@address"}) {
    for (std::string& name : user.values(std::string("General/Interfaces/NetworkInterface/") + attribute))
      names.push_back(std::move(name));
  }
  if (const auto deprecated = user.value("General/NetworkInterfaceAddress")) {
    for (const auto name : std::views::split(*deprecated, ',')) names.emplace_back(name.begin(), name.end());
  }
  const std::vector<std::string> any = user.values("General/Interfaces/NetworkInterface/@autodetermine");
  if (std::ranges::any_of(any, [](const std::string& value) { return equals(value, "true"); })) return {};
  std::erase_if(names, [](const std::string& name) { return equals(name, "auto") || name.empty(); });
  return user.sets("General/Interfaces") || user.sets("General/NetworkInterfaceAddress")
             ? names
             : settings.interfaces;
}

}  // namespace

Result<DdsConfig> dds_config(std::uint32_t domain, const DiscoverySettings& settings,
                             const std::string& user_config) {
  if (const auto ok = check_names(settings.peers, "peers"); !ok) return tl::unexpected(ok.error());
  if (const auto ok = check_names(settings.interfaces, "interfaces"); !ok) return tl::unexpected(ok.error());
  const Result<CycloneSettings> user = CycloneSettings::read(user_config, domain);
  if (!user) return tl::unexpected(user.error());
  if (const auto ok = check_partitions(*user); !ok) return tl::unexpected(ok.error());
  DdsConfig config = Composition(settings, *user).result(domain, user_config);
  config.interfaces = chosen_interfaces(*user, settings);
  return config;
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

/// A datagram on a port of this host may come from any interface: without DontRoute each link would talk to
/// addresses that are not of its network, too. Peers may be behind a router. Nodes of one host meet on the
/// loopback, and would do so once more on every other link if its multicasts came back.
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
