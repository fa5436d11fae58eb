#include "core/dds_config.h"

#include <fnmatch.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <optional>
#include <ranges>
#include <string_view>

#include "core/cyclone_settings.h"
#include "core/ip_address.h"

namespace sft::core {

namespace {

constexpr std::array control_topics{"sft_endpoint", "sft_request", "sft_liveliness"};
constexpr std::size_t fragment_bytes_min = 128;
constexpr std::size_t sample_bytes_min = 65'536;  // of control samples; the largest have some 30,000

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

/// What SFT cannot do without, where the user may have set it otherwise.
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
           "2147483647 B", "announcements with the description of a type may have 64 kB"},
    Demand{"Compatibility", "ManySocketsMode",
           [](const std::string& v) { return equals(v, "none") || equals(v, "false"); }, "single",
           "nodes could not be reached"},
};

constexpr Demand predictable_port{
    "Discovery", "ParticipantIndex", [](const std::string& v) { return equals(v, "none"); }, "auto",
    "without multicast, nodes are looked for at the ports that DDS derives from the index"};

std::string path_of(const Demand& demand) {
  return std::string(demand.group) + "/" + std::string(demand.name);
}

/// The settings of a domain, put together.
class Composition {
 public:
  Composition(const DiscoverySettings& settings, const CycloneSettings& user)
      : settings_(settings),
        user_(user),
        multicast_(user.value("General/AllowMulticast").value_or(multicast_by_ours())) {}

  DdsConfig result(const std::string& user_config) const {
    DdsConfig config{{}, !finds_by_peers_only() && !equals(multicast_, "spdp"), summary(), {}};
    std::string insisted;
    for (const Demand& demand : demands) insisted += insist_on(demand, config.warnings);
    if (finds_by_peers_only()) insisted += insist_on(predictable_port, config.warnings);
    // What comes later wins.
    config.text = ours() + "," + (user_config.empty() ? "" : user_config + ",") + document(insisted);
    add_remarks(config.warnings);
    return config;
  }

 private:
  /// To peers that it does not reach, nothing must go by it once they are found.
  std::string multicast_by_ours() const {
    if (!settings_.multicast) return "false";
    return has_peers() ? "spdp" : "default";
  }
  bool finds_by_peers_only() const { return equals(multicast_, "false"); }
  bool has_peers() const { return !settings_.peers.empty() || user_.sets("Discovery/Peers"); }
  bool user_chose_interfaces() const {
    return user_.sets("General/Interfaces") || user_.sets("General/NetworkInterfaceAddress");
  }

  /// Acknowledgements that do not wait and heartbeats that come at once make a newcomer's first request
  /// arrive within milliseconds, and soon where datagrams get lost; what repeats while nothing happens is
  /// kept rare.
  std::string ours() const {
    return document(element("General", general()) + element("Discovery", discovery()) +
                    element("Internal", element("PreEmptiveAckDelay", "0 ms") + element("NackDelay", "1 ms") +
                                            "<HeartbeatInterval max=\"2 s\">20 ms</HeartbeatInterval>" +
                                            element("MultipleReceiveThreads", "false")));
  }

  std::string general() const {
    const std::string text = element("AllowMulticast", multicast_by_ours());
    if (settings_.interfaces.empty() || user_chose_interfaces()) return text;
    std::string interfaces;
    for (const std::string& name : settings_.interfaces) {
      // Of a network, too, Cyclone wants an address, and takes the bits of the interface.
      const std::optional<IpNetwork> network = parse_ip_network(name);
      interfaces += std::string("<NetworkInterface ") + (network ? "address" : "name") + "=\"" +
                    (network ? format(network->ip) : name) + "\" presence_required=\"false\"/>";
    }
    return text + element("Interfaces", interfaces);
  }

  /// A peer is asked at every port that a node of it may have, each time: that has to be rare, and they few.
  std::string discovery() const {
    if (!finds_by_peers_only() && !has_peers())
      return element("SPDPInterval", "10 s") + element("LeaseDuration", "20 s");
    std::string peers;
    if (finds_by_peers_only()) peers += "<Peer Address=\"localhost\"/>";
    for (const std::string& peer : settings_.peers) peers += "<Peer Address=\"" + peer + "\"/>";
    return element("SPDPInterval", "120 s") + element("LeaseDuration", "150 s") +
           element("ParticipantIndex", "auto") + element("MaxAutoParticipantIndex", "20") +
           element("Peers", peers);
  }

  std::string summary() const {
    std::vector<std::string> peers = settings_.peers;
    for (std::string& peer : user_.values("Discovery/Peers/Peer/@Address")) peers.push_back(std::move(peer));
    std::string text = finds_by_peers_only() ? "on this host" : "by multicast";
    if (!peers.empty()) text += ", and on the peers " + list(peers);
    if (!settings_.interfaces.empty() && !user_chose_interfaces())
      text += ", by " + list(settings_.interfaces);
    return text;
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

}  // namespace

Result<DdsConfig> dds_config(std::uint32_t domain, const DiscoverySettings& settings,
                             const std::string& user_config) {
  if (const auto ok = check_names(settings.peers, "peers"); !ok) return tl::unexpected(ok.error());
  if (const auto ok = check_names(settings.interfaces, "interfaces"); !ok) return tl::unexpected(ok.error());
  const Result<CycloneSettings> user = CycloneSettings::read(user_config, domain);
  if (!user) return tl::unexpected(user.error());
  if (const auto ok = check_partitions(*user); !ok) return tl::unexpected(ok.error());
  return Composition(settings, *user).result(user_config);
}

Result<std::vector<std::string>> discovery_interfaces(std::uint32_t domain, const DiscoverySettings& settings,
                                                      const std::string& user_config) {
  const Result<CycloneSettings> user = CycloneSettings::read(user_config, domain);
  if (!user) return tl::unexpected(user.error());
  std::vector<std::string> names;
  for (const char* attribute : {"@name", "@address"}) {
    for (std::string& name : user->values(std::string("General/Interfaces/NetworkInterface/") + attribute))
      names.push_back(std::move(name));
  }
  if (const auto deprecated = user->value("General/NetworkInterfaceAddress")) {
    for (const auto name : std::views::split(*deprecated, ',')) names.emplace_back(name.begin(), name.end());
  }
  return user->sets("General/Interfaces") || !names.empty() ? names : settings.interfaces;
}

}  // namespace sft::core
