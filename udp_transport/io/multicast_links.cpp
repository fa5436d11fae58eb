#include "udp_transport/io/multicast_links.h"

#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>

#include "udp_transport/io/interfaces.h"

namespace sft::udp {

std::string why_no_multicast(const std::string& interface, unsigned flags, bool wireless, Multicast use) {
  if (use == Multicast::everywhere) return "";
  if (use == Multicast::off) return "multicast is off by option";
  if ((flags & IFF_LOOPBACK) != 0) return "it is on this host";
  if ((flags & IFF_MULTICAST) == 0) return "interface " + interface + " has no multicast";
  if ((flags & IFF_POINTOPOINT) != 0) return "interface " + interface + " leads to one host only";
  if (wireless) return "interface " + interface + " is wireless";
  return "";
}

std::vector<MulticastLink> multicast_links(Multicast use) {
  std::vector<MulticastLink> links;
  ifaddrs* list = nullptr;
  if (::getifaddrs(&list) != 0) return links;
  for (const ifaddrs* i = list; i != nullptr; i = i->ifa_next) {
    const bool has_address =
        i->ifa_addr != nullptr && i->ifa_addr->sa_family == AF_INET && i->ifa_netmask != nullptr;
    if ((i->ifa_flags & IFF_UP) == 0 || !has_address) continue;
    const auto ipv4 = [](const sockaddr& a) {
      return ntohl(reinterpret_cast<const sockaddr_in&>(a).sin_addr.s_addr);
    };
    const std::string name = i->ifa_name;
    links.push_back({name, ipv4(*i->ifa_addr), ipv4(*i->ifa_netmask),
                     why_no_multicast(name, i->ifa_flags, is_wireless(name), use)});
  }
  ::freeifaddrs(list);
  return links;
}

/// An empty list may mean that the system refused to list the links, so the list is requested again.
const std::vector<MulticastLink>& KnownMulticastLinks::list(Multicast use) {
  const std::uint64_t changes = monitor_.changes();
  if (links_.empty() || changes != changes_) links_ = ask_(use);
  changes_ = changes;
  return links_;
}

}  // namespace sft::udp
