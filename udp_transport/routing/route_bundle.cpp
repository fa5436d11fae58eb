#include "udp_transport/routing/gathered.h"

#include <algorithm>

namespace sft::udp {

void Gathered::add(const std::shared_ptr<Destination>& to) {
  if (std::find(destinations.begin(), destinations.end(), to) == destinations.end())
    destinations.push_back(to);
}

std::vector<Gathered> gather(std::span<const core::Route> routes, DestinationDirectory& directory) {
  std::vector<Gathered> groups;
  for (const core::Route& route : routes) {
    const auto* address = std::get_if<core::UdpAddress>(&route.destination);
    if (address == nullptr) continue;
    const core::Wanted wanted{route.mask, route.gate == nullptr ? 0 : route.gate->min_period_us()};
    const core::EndpointId late_reader = route.history == 0 ? 0 : route.reader;
    auto group = std::find_if(groups.begin(), groups.end(), [&](const Gathered& g) {
      return g.wanted == wanted && g.late_reader == late_reader && g.spare == route.spare;
    });
    if (group == groups.end())
      group = groups.insert(groups.end(), {wanted, late_reader, route.spare, route.gate});
    const std::shared_ptr<Destination> destination = directory.find(*address);
    group->readers.emplace_back(route.reader, destination.get());
    if (route.reliable) group->reliable[destination.get()].insert(route.reader);
    group->add(destination);
  }
  std::stable_partition(groups.begin(), groups.end(), [](const Gathered& group) { return !group.spare; });
  return groups;
}

}  // namespace sft::udp
