#include "udp_transport/routing/mask_sharing.h"

#include <algorithm>
#include <set>
#include <utility>

#include "udp_transport/multicast/one_copy.h"

namespace sft::udp {

void MaskSharing::look_at(const std::vector<RouteBundle>& routes) {
  std::map<const Destination*, Place> places;
  std::set<const Destination*> gets_more;
  for (const RouteBundle& bundle : routes) {
    for (const std::shared_ptr<Destination>& to : bundle.destinations) {
      if (bundle.is_for_some_samples()) gets_more.insert(to.get());
      Place& place = places[to.get()];
      add_to_copy(place.together, bundle.wanted.selection, place.asked.empty());
      place.asked.push_back(bundle.wanted.selection);
      place.datagram_bytes = to->path().datagram_bytes();
      if (bundle.reliable.contains(to.get())) place.mark = PlaceMark::in_channel;
    }
  }
  std::erase_if(places, [&](const auto& item) {
    return item.second.asked.size() < 2 || gets_more.contains(item.first);
  });
  for (auto& [to, place] : places) {
    const auto before = several_.find(to);
    if (before == several_.end()) continue;
    place.shares = before->second.shares;
    place.is_decided =
        before->second.is_decided && std::ranges::is_permutation(place.asked, before->second.asked);
  }
  several_ = std::move(places);
}

bool MaskSharing::decide(BodySizes& sizes, Time now) {
  const bool all = now >= next_look_;
  if (all) next_look_ = now + pause;
  bool changed = false;
  for (auto& [to, place] : several_) {
    if (place.is_decided && !all) continue;
    if (!sizes.known_all(place.asked)) {
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
  return std::ranges::any_of(several_, [&](const auto& item) {
    return !item.second.is_decided && sizes.known_all(item.second.asked);
  });
}

/// Returns true if one copy for all readers is better than separate copies. The one copy usually has fewer
/// bytes than the separate copies together, except if some readers request only parts of its fields. But
/// with one copy, a reader of few fields waits for all fields.
bool MaskSharing::is_better_shared(const Place& place, const BodySizes& sizes) const {
  const double body = sizes.bytes_of(place.together);
  const bool is_asked_for = std::ranges::find(place.asked, place.together) != place.asked.end();
  if (body > limits_.merged_body_max && !is_asked_for) return false;
  const double together = wire_bytes(body, place.datagram_bytes, place.mark);
  double apart = 0;
  for (const Selection& one : place.asked)
    apart += wire_bytes(sizes.bytes_of(one), place.datagram_bytes, place.mark);
  return apart > (place.shares ? (1 + limits_.wire_max) / 2 : limits_.wire_max) * together;
}

bool MaskSharing::shares(const Destination* to) const {
  const auto found = several_.find(to);
  return found != several_.end() && found->second.shares;
}

double MaskSharing::bytes_to(const Destination* to, const std::vector<Selection>& asked, PlaceMark place,
                             const BodySizes& sizes) const {
  const std::size_t datagram_bytes = to->path().datagram_bytes();
  if (const auto found = several_.find(to); found != several_.end() && found->second.shares)
    return wire_bytes(sizes.bytes_of(found->second.together), datagram_bytes, place);
  double bytes = 0;
  for (const Selection& one : asked) bytes += wire_bytes(sizes.bytes_of(one), datagram_bytes, place);
  return bytes;
}

void MaskSharing::merge(std::vector<RouteBundle>& routes) const {
  for (const auto& [to, place] : several_) {
    if (!place.shares) continue;
    const auto is_it = [it = to](const Destination* one) { return one == it; };
    RouteBundle together = take_out(routes, is_it);
    if (together.destinations.empty()) continue;  // nothing to merge: the destination is in a multicast group
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
