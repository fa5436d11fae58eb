#include "udp_transport/routing/mask_sharing.h"

#include <algorithm>
#include <set>
#include <utility>

namespace sft::udp {

void MaskSharing::look_at(const std::vector<RouteBundle>& routes) {
  std::map<const Destination*, Place> places;
  std::set<const Destination*> gets_more;
  for (const RouteBundle& bundle : routes) {
    for (const std::shared_ptr<Destination>& to : bundle.destinations) {
      if (bundle.is_for_more_than_a_mask()) gets_more.insert(to.get());
      Place& place = places[to.get()];
      place.masks.push_back(bundle.wanted.selection.mask());
      place.datagram_bytes = to->path().datagram_bytes();
      if (bundle.reliable.contains(to.get())) place.mark = PlaceMark::in_channel;
    }
  }
  std::erase_if(places, [&](const auto& item) {
    return item.second.masks.size() < 2 || gets_more.contains(item.first);
  });
  for (auto& [to, place] : places) {
    place.fields = FieldMask(place.masks.front().leaves());
    for (const FieldMask& mask : place.masks) place.fields |= mask;
    const auto before = several_.find(to);
    if (before == several_.end()) continue;
    place.shares = before->second.shares;
    place.is_decided =
        before->second.is_decided && std::ranges::is_permutation(place.masks, before->second.masks);
  }
  several_ = std::move(places);
}

bool MaskSharing::decide(BodySizes& sizes, Time now) {
  const bool all = now >= next_look_;
  if (all) next_look_ = now + pause;
  bool changed = false;
  for (auto& [to, place] : several_) {
    if (place.is_decided && !all) continue;
    if (!sizes.known(place.fields)) {
      sizes.measure_next();
      continue;
    }
    place.is_decided = true;
    const bool shares = is_better_shared(place, sizes);
    changed |= std::exchange(place.shares, shares) != shares;
  }
  return changed;
}

bool MaskSharing::is_undecided(const BodySizes& sizes) const {
  return std::ranges::any_of(
      several_, [&](const auto& item) { return !item.second.is_decided && sizes.known(item.second.fields); });
}

/// One copy never has more bytes than all copies together. But a reader of few fields then waits for many.
bool MaskSharing::is_better_shared(const Place& place, const BodySizes& sizes) const {
  const double together = wire_bytes(sizes.bytes_of(place.fields), place.datagram_bytes, place.mark);
  double apart = 0;
  for (const FieldMask& mask : place.masks)
    apart += wire_bytes(sizes.bytes_of(mask), place.datagram_bytes, place.mark);
  return apart > (place.shares ? (1 + wire_max_) / 2 : wire_max_) * together;
}

bool MaskSharing::shares(const Destination* to) const {
  const auto found = several_.find(to);
  return found != several_.end() && found->second.shares;
}

double MaskSharing::bytes_to(const Destination* to, const std::vector<FieldMask>& masks, PlaceMark place,
                             const BodySizes& sizes) const {
  const std::size_t datagram_bytes = to->path().datagram_bytes();
  if (const auto found = several_.find(to); found != several_.end() && found->second.shares)
    return wire_bytes(sizes.bytes_of(found->second.fields), datagram_bytes, place);
  double bytes = 0;
  for (const FieldMask& mask : masks) bytes += wire_bytes(sizes.bytes_of(mask), datagram_bytes, place);
  return bytes;
}

void MaskSharing::merge(std::vector<RouteBundle>& routes) const {
  for (const auto& [to, place] : several_) {
    if (!place.shares) continue;
    const auto is_it = [to = to](const Destination* one) { return one == to; };
    RouteBundle together = take_out(routes, is_it);
    if (together.destinations.empty()) continue;  // it is in a multicast group
    const auto known = std::ranges::find_if(routes, [&](const RouteBundle& bundle) {
      return bundle.merged && !bundle.multicast && bundle.wanted == together.wanted;
    });
    if (known == routes.end()) {
      routes.insert(routes.begin(), std::move(together));
    } else {
      known->absorb(std::move(together));
    }
  }
}

}  // namespace sft::udp
