#include "core/discovery/desired_links.h"

#include <algorithm>
#include <array>
#include <string_view>

namespace sft::core {

namespace {

/// Lists the interfaces that fit the rules, and picks links among them.
class Choice {
 public:
  Choice(std::span<const HostInterface> interfaces, const LinkRules& rules,
         std::span<const LinkSpec> in_force)
      : interfaces_(interfaces), rules_(rules), in_force_(in_force) {}

  DesiredLinks made() {
    pick_loopback();
    const bool has_loopback = !result_.links.empty();
    pick_ipv4(!has_loopback);
    const bool only_ipv6 = std::ranges::none_of(interfaces_, [&](const HostInterface& i) {
      return !i.loopback && i.up && i.ip.is_ipv4() && fits(i);
    });
    if (only_ipv6) pick_ipv6(!has_loopback);
    const bool wants_others = rules_.multicast || rules_.peers;
    const bool lists_others =
        std::ranges::any_of(rules_.listed, [&](const auto& one) { return !names_loopback(one); });
    result_.waits_for_network = wants_others && (rules_.listed.empty() || lists_others) &&
                                std::ranges::all_of(result_.links, &LinkSpec::loopback);
    remark_on_listed();
    return std::move(result_);
  }

 private:
  bool is_listed(const HostInterface& interface) const {
    return std::ranges::any_of(rules_.listed, [&](const auto& one) { return is_named(interface, one); });
  }
  bool names_loopback(const std::string& one) const {
    return std::ranges::any_of(interfaces_, [&](const auto& i) { return i.loopback && is_named(i, one); });
  }
  /// Without multicast nobody would be found there, unless peers are asked one by one.
  bool fits(const HostInterface& interface) const {
    if (!rules_.listed.empty()) return is_listed(interface);
    return !belongs_to_containers(interface.name) && (interface.multicast || rules_.peers);
  }
  bool is_in_force(const LinkSpec& link) const {
    return std::ranges::find(in_force_, link) != in_force_.end();
  }

  void pick(const HostInterface& interface, const LinkSpec& link) {
    if (!interface.up && !is_in_force(link)) return;
    if (result_.links.size() == links_max) {
      result_.remarks.push_back(interface.name + " is left out: discovery uses " + std::to_string(links_max) +
                                " addresses at most");
      return;
    }
    result_.links.push_back(link);
  }

  void pick_loopback() {
    for (const HostInterface& i : interfaces_) {
      if (i.loopback && i.ip.is_ipv4() && result_.links.empty())
        pick(i, {i.name, i.ip, i.prefix_bits, true, true, i.index});
    }
  }

  /// One address of a network is enough, and a second one in the same network would find everybody twice. The
  /// one that is in use goes first.
  void pick_ipv4(bool reaches_own_host) {
    std::vector<const HostInterface*> candidates;
    for (const HostInterface& i : interfaces_) {
      if (!i.loopback && i.ip.is_ipv4() && fits(i)) candidates.push_back(&i);
    }
    const auto spec = [&](const HostInterface& i) {
      return LinkSpec{i.name, i.ip, i.prefix_bits, false, reaches_own_host, i.index};
    };
    std::ranges::stable_partition(candidates, [&](const auto* i) { return is_in_force(spec(*i)); });
    for (const HostInterface* i : candidates) {
      const bool twice = std::ranges::any_of(result_.links, [&](const LinkSpec& link) {
        return link.interface == i->name && in_one_network(link.ip, i->ip, i->prefix_bits);
      });
      if (!twice) pick(*i, spec(*i));
    }
  }

  void pick_ipv6(bool reaches_own_host) {
    for (const HostInterface& i : interfaces_) {
      if (i.loopback || i.ip.is_any() || i.ip.is_ipv4() || !fits(i)) continue;
      if (std::ranges::find(result_.links, i.name, &LinkSpec::interface) == result_.links.end())
        pick(i, {i.name, {}, 0, false, reaches_own_host, i.index});
    }
  }

  void remark_on_listed() {
    for (const std::string& one : rules_.listed) {
      const auto named = [&](const HostInterface& i) { return is_named(i, one); };
      const bool used = std::ranges::any_of(interfaces_, [&](const HostInterface& i) {
        return named(i) &&
               std::ranges::find(result_.links, i.name, &LinkSpec::interface) != result_.links.end();
      });
      const auto there = std::ranges::find_if(interfaces_, named);
      if (there == interfaces_.end()) {
        result_.remarks.push_back(one + " is not there");
      } else if (!there->up) {
        result_.remarks.push_back(one + " is down");
      } else if (!used) {
        result_.remarks.push_back(one + " has no address of use");
      }
    }
  }

  std::span<const HostInterface> interfaces_;
  const LinkRules& rules_;
  std::span<const LinkSpec> in_force_;
  DesiredLinks result_;
};

}  // namespace

DesiredLinks desired_links(std::span<const HostInterface> interfaces, const LinkRules& rules,
                           std::span<const LinkSpec> in_force) {
  return Choice(interfaces, rules, in_force).made();
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
