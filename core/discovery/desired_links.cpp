#include "core/discovery/desired_links.h"

#include <algorithm>
#include <array>
#include <string_view>

namespace sft::core {

namespace {

bool is_one_of(std::span<const LinkSpec> links, const LinkSpec& link) {
  return std::ranges::find(links, link) != links.end();
}

bool is_listed(const HostInterface& interface, const LinkRules& rules) {
  return std::ranges::any_of(rules.listed, [&](const auto& one) { return is_named(interface, one); });
}

/// Returns true if a link can use the interface. On a link without multicast, nodes find each other only if
/// peers are asked one by one.
bool fits(const HostInterface& interface, const LinkRules& rules) {
  if (!rules.listed.empty()) return is_listed(interface, rules);
  return !belongs_to_containers(interface.name) && (interface.multicast || rules.peers);
}

LinkSpec link_at(const HostInterface& interface, bool reaches_own_host) {
  if (!interface.ip.is_ipv4()) return {interface.name, {}, 0, false, reaches_own_host, interface.index};
  return {interface.name,     interface.ip,     interface.prefix_bits,
          interface.loopback, reaches_own_host, interface.index};
}

/// Returns true if one of the links is on the same interface, in the same network as this address. With a
/// second link in one network, each node would be found twice.
bool cover(std::span<const LinkSpec> links, const HostInterface& interface) {
  return std::ranges::any_of(links, [&](const LinkSpec& link) {
    return link.interface == interface.name &&
           (!interface.ip.is_ipv4() || in_one_network(link.ip, interface.ip, interface.prefix_bits));
  });
}

/// Returns the addresses other than the loopback that links may have. IPv4 addresses that have a link at
/// present come first, so that they keep the link. IPv6 addresses are returned only if there are no others.
std::vector<const HostInterface*> candidates(std::span<const HostInterface> interfaces,
                                             const LinkRules& rules, const auto& is_in_force) {
  const auto fits_beside_loopback = [&](const HostInterface& i) { return !i.loopback && fits(i, rules); };
  const bool has_ipv4 = std::ranges::any_of(
      interfaces, [&](const HostInterface& i) { return fits_beside_loopback(i) && i.up && i.ip.is_ipv4(); });
  std::vector<const HostInterface*> addresses;
  for (const HostInterface& i : interfaces) {
    const bool is_of_use = i.ip.is_ipv4() || (!has_ipv4 && !i.ip.is_any());
    if (is_of_use && fits_beside_loopback(i)) addresses.push_back(&i);
  }
  std::ranges::stable_sort(addresses, {}, [&](const HostInterface* i) {
    return !i->ip.is_ipv4() ? 2 : is_in_force(*i) ? 0 : 1;
  });
  return addresses;
}

bool wait_for_network(std::span<const LinkSpec> links, std::span<const HostInterface> interfaces,
                      const LinkRules& rules) {
  const auto names_loopback = [&](const std::string& one) {
    return std::ranges::any_of(interfaces, [&](const auto& i) { return i.loopback && is_named(i, one); });
  };
  const bool wants_others = (rules.multicast || rules.peers) &&
                            (rules.listed.empty() || !std::ranges::all_of(rules.listed, names_loopback));
  return wants_others && std::ranges::all_of(links, &LinkSpec::loopback);
}

/// Returns why the interfaces that `listed` names are not in use; returns an empty text if they are in use.
std::string why_unused(const std::string& listed, std::span<const HostInterface> interfaces,
                       std::span<const LinkSpec> links) {
  const auto named = [&](const HostInterface& i) { return is_named(i, listed); };
  const auto first = std::ranges::find_if(interfaces, named);
  if (first == interfaces.end()) return " is not there";
  if (!first->up) return " is down";
  const bool is_used = std::ranges::any_of(interfaces, [&](const HostInterface& i) {
    return named(i) && std::ranges::find(links, i.name, &LinkSpec::interface) != links.end();
  });
  return is_used ? "" : " has no address of use";
}

}  // namespace

DesiredLinks desired_links(std::span<const HostInterface> interfaces, const LinkRules& rules,
                           std::span<const LinkSpec> in_force) {
  DesiredLinks desired;
  const auto loopback = std::ranges::find_if(interfaces, [&](const HostInterface& i) {
    return i.loopback && i.ip.is_ipv4() && (i.up || is_one_of(in_force, link_at(i, true)));
  });
  const bool has_loopback = loopback != interfaces.end();
  if (has_loopback) desired.links.push_back(link_at(*loopback, true));
  const auto is_in_force = [&](const HostInterface& i) {
    return is_one_of(in_force, link_at(i, !has_loopback));
  };
  for (const HostInterface* i : candidates(interfaces, rules, is_in_force)) {
    if ((!i->up && !is_in_force(*i)) || cover(desired.links, *i)) continue;
    if (desired.links.size() < links_max) {
      desired.links.push_back(link_at(*i, !has_loopback));
    } else {
      desired.remarks.push_back(i->name + " is left out: discovery uses " + std::to_string(links_max) +
                                " addresses at most");
    }
  }
  desired.waits_for_network = wait_for_network(desired.links, interfaces, rules);
  for (const HostInterface& i : interfaces) {
    const bool is_left_out = i.up && !i.loopback && !i.ip.is_any() && !i.multicast && !fits(i, rules) &&
                             !belongs_to_containers(i.name);
    if (desired.waits_for_network && is_left_out && rules.listed.empty())
      desired.remarks.push_back(i.name + " (" + format(i.ip) +
                                ") is left out, since it has no multicast: ip link set dev " + i.name +
                                " multicast on, or name the hosts beyond it as peers, on both sides");
  }
  for (const std::string& listed : rules.listed) {
    if (const std::string why = why_unused(listed, interfaces, desired.links); !why.empty())
      desired.remarks.push_back(listed + why);
  }
  return desired;
}

bool leads_to(const LinkSpec& link, const IpAddress& address) {
  return !link.ip.is_any() && in_one_network(link.ip, address, link.prefix_bits);
}

std::string describe(std::span<const LinkSpec> links) {
  std::string text;
  for (const LinkSpec& link : links) {
    text += (text.empty() ? "" : ", ") + link.interface;
    if (link.loopback) continue;
    text += link.ip.is_any() ? " (IPv6)" : " (" + format(link.ip) + ")";
  }
  return text;
}

bool belongs_to_containers(const std::string& interface) {
  constexpr std::array<std::string_view, 10> prefixes{"docker", "veth",   "virbr", "br-",  "lxcbr",
                                                      "lxdbr",  "podman", "cni",   "cali", "flannel"};
  return std::ranges::any_of(prefixes,
                             [&](std::string_view prefix) { return interface.starts_with(prefix); });
}

}  // namespace sft::core
