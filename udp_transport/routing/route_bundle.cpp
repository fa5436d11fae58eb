#include "udp_transport/routing/route_bundle.h"

#include <algorithm>

#include "udp_transport/multicast/one_copy.h"

namespace sft::udp {

void RouteBundle::add(const std::shared_ptr<Destination>& to) {
  if (std::find(destinations.begin(), destinations.end(), to) == destinations.end())
    destinations.push_back(to);
}

void RouteBundle::absorb(RouteBundle other) {
  add_to_copy(wanted.selection, other.wanted.selection, destinations.empty());
  for (const std::shared_ptr<Destination>& to : other.destinations) add(to);
  readers.insert(readers.end(), other.readers.begin(), other.readers.end());
  for (auto& [to, of_destination] : other.reliable) reliable[to].merge(of_destination);
}

RouteBundle take_out(std::vector<RouteBundle>& routes,
                     const std::function<bool(const Destination*)>& is_one) {
  RouteBundle all{.wanted = {FieldMask(routes.front().wanted.selection.mask().leaves()), 0}, .merged = true};
  const auto leads_to_one = [&](const std::shared_ptr<Destination>& to) { return is_one(to.get()); };
  for (RouteBundle& bundle : routes) {
    if (bundle.merged || std::ranges::none_of(bundle.destinations, leads_to_one)) continue;
    all.wanted.min_period_us = bundle.wanted.min_period_us;
    all.gate = bundle.gate;
    RouteBundle taken{.wanted = bundle.wanted};
    std::erase_if(bundle.destinations, [&](const std::shared_ptr<Destination>& to) {
      if (leads_to_one(to)) taken.destinations.push_back(to);
      return leads_to_one(to);
    });
    std::erase_if(bundle.readers, [&](const auto& reader) {
      if (is_one(reader.second)) taken.readers.push_back(reader);
      return is_one(reader.second);
    });
    std::erase_if(bundle.reliable, [&](auto& item) {
      if (is_one(item.first)) taken.reliable.insert(item);
      return is_one(item.first);
    });
    all.absorb(std::move(taken));
  }
  return all;
}

std::vector<RouteBundle> bundle_routes(std::span<const core::Route> routes, DestinationDirectory& directory) {
  std::vector<RouteBundle> bundles;
  for (const core::Route& route : routes) {
    const auto* address = std::get_if<core::UdpAddress>(&route.destination);
    if (address == nullptr) continue;
    const core::Wanted wanted{route.selection, route.gate == nullptr ? 0 : route.gate->min_period_us()};
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
