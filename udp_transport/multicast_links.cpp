#include "udp_transport/multicast_links.h"

#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>
#include <unistd.h>

namespace sft::udp {

namespace {

std::string refusal(const ifaddrs& entry, Multicast use) {
  const std::string name = entry.ifa_name;
  if (use == Multicast::everywhere) return "";
  if (use == Multicast::off) return "multicast is off by option";
  if ((entry.ifa_flags & IFF_LOOPBACK) != 0) return "it is on this host";
  if ((entry.ifa_flags & IFF_MULTICAST) == 0) return "interface " + name + " has no multicast";
  if ((entry.ifa_flags & IFF_POINTOPOINT) != 0) return "interface " + name + " leads to one host only";
  if (is_wireless(name)) return "interface " + name + " is wireless";
  return "";
}

}  // namespace

bool is_wireless(const std::string& interface) {
  const std::string folder = "/sys/class/net/" + interface;
  return ::access((folder + "/wireless").c_str(), F_OK) == 0 ||
         ::access((folder + "/phy80211").c_str(), F_OK) == 0;
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
    links.push_back({i->ifa_name, ipv4(*i->ifa_addr), ipv4(*i->ifa_netmask), refusal(*i, use)});
  }
  ::freeifaddrs(list);
  return links;
}

}  // namespace sft::udp
