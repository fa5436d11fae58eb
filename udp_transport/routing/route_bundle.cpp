#include "udp_transport/routing/route_bundle.h"

#include <algorithm>

namespace sft::udp {

void RouteBundle::add(const std::shared_ptr<Destination>& to) {
  if (std::find(destinations.begin(), destinations.end(), to) == destinations.end())
    destinations.push_back(to);
}

std::vector<RouteBundle> bundle_routes(std::span<const core::Route> routes, DestinationDirectory& directory) {
  std::vector<RouteBundle> bundles;
  for (const core::Route& route : routes) {
    const auto* address = std::get_if<core::UdpAddress>(&route.destination);
    if (address == nullptr) continue;
    const core::Wanted wanted{route.mask, route.gate == nullptr ? 0 : route.gate->min_period_us()};
    const core::EndpointId late_reader = route.history == 0 ? 0 : route.reader;
    auto bundle = std::find_if(bundles.begin(), bundles.end(), [&](const RouteBundle& b) {
      return b.wanted == wanted && b.late_reader == late_reader && b.fallback == route.fallback;
    });
    if (bundle == bundles.end())
      bundle = bundles.insert(bundles.end(), {wanted, late_reader, route.fallback, route.gate});
    const std::shared_ptr<Destination> destination = directory.find(*address);
    bundle->readers.emplace_back(route.reader, destination.get());
    if (route.reliable) bundle->reliable[destination.get()].insert(route.reader);
    bundle->add(destination);
  }
  std::stable_partition(bundles.begin(), bundles.end(),
                        [](const RouteBundle& bundle) { return !bundle.fallback; });
  return bundles;
}

}  // namespace sft::udp
