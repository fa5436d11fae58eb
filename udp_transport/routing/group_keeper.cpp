#include "udp_transport/routing/group_keeper.h"

#include <algorithm>
#include <array>
#include <functional>
#include <utility>

#include "udp_transport/io/interfaces.h"

namespace sft::udp {

namespace {

/// Masks of larger types are named by their hashes only.
constexpr std::size_t leaves_max = 64 * WireMask::words_max;

template <class Range, class Value>
bool holds(const Range& range, const Value& value) {
  return std::ranges::find(range, value) != std::ranges::end(range);
}

}  // namespace

GroupKeeper::GroupKeeper(Setup setup)
    : setup_(std::move(setup)), too_many_leaves_(leaf_count(*setup_.type) > leaves_max) {}

void GroupKeeper::merge(std::vector<RouteBundle>& routes, Time now) {
  look_at(routes, now);
  choose_masks(now);
  keep_possible();
  explain(routes);
  for (const Planned& planned : planned_) merge(planned, routes);
  std::erase_if(routes, [](const RouteBundle& bundle) { return bundle.destinations.empty(); });
  std::ranges::stable_partition(routes, [](const RouteBundle& bundle) { return !bundle.fallback; });
  replan_at_ = std::max(replan_at_, now + settling);
  found_.clear();
}

void GroupKeeper::look_at(const std::vector<RouteBundle>& routes, Time now) {
  candidates_.clear();
  links_ = setup_.use == Multicast::off ? std::vector<MulticastLink>{} : setup_.links(setup_.use);
  for (const RouteBundle& bundle : routes) {
    for (const std::shared_ptr<Destination>& to : bundle.destinations) {
      const auto [known, is_new] = candidates_.try_emplace(to.get());
      Candidate& candidate = known->second;
      if (is_new) candidate.to = to;
      if (is_new) choose_link(candidate, now);
      if (bundle.gate != nullptr) candidate.refusal = "a reader there has a maximum rate";
      if (bundle.late_reader != 0) candidate.refusal = "a reader there is sent what was retained";
      if (bundle.fallback) candidate.refusal = "a reader there is served in shared memory";
      if (!holds(candidate.masks, bundle.wanted.mask)) candidate.masks.push_back(bundle.wanted.mask);
      candidate.reliable = candidate.reliable || bundle.reliable.contains(to.get());
    }
  }
}

void GroupKeeper::choose_link(Candidate& candidate, Time now) const {
  const core::IpAddress address = candidate.to->path().address().ip;
  if (setup_.use == Multicast::off) candidate.refusal = "multicast is off by option";
  if (now < packed_until_) candidate.refusal = "samples that are published together share datagrams";
  if (too_many_leaves_) candidate.refusal = "its type has too many fields";
  const auto deaf = deaf_until_.find(candidate.to.get());
  if (deaf != deaf_until_.end() && now < deaf->second) candidate.refusal = "no multicast comes to it";
  if (!address.is_ipv4()) candidate.refusal = "it is reached by IPv6";
  if (!candidate.refusal.empty()) return;
  const std::uint32_t ip = address.ipv4();
  const bool strict = setup_.use != Multicast::everywhere;
  for (std::size_t i = 0; i < links_.size(); ++i) {
    const MulticastLink& link = links_[i];
    if ((ip & link.netmask) != (link.own & link.netmask)) continue;
    if (link.refusal.empty() && (ip != link.own || !strict)) {
      candidate.link = i;
      candidate.refusal.clear();
      return;
    }
    candidate.refusal = ip == link.own ? "it is on this host" : link.refusal;
  }
  if (candidate.refusal.empty()) candidate.refusal = "it is not on a link of this host";
}

/// The most wanted ones, as many as are measured together. Destinations that want others, too, are served
/// alone.
void GroupKeeper::choose_masks(Time now) {
  std::vector<std::pair<FieldMask, std::size_t>> wanted;
  std::size_t possible = 0;
  for (const auto& [to, candidate] : candidates_) {
    if (!candidate.refusal.empty()) continue;
    ++possible;
    for (const FieldMask& mask : candidate.masks) {
      const auto known = std::ranges::find_if(wanted, [&](const auto& item) { return item.first == mask; });
      if (known == wanted.end()) {
        wanted.emplace_back(mask, 1);
      } else {
        ++known->second;
      }
    }
  }
  std::ranges::stable_sort(wanted, std::greater{}, [](const auto& item) { return item.second; });
  if (wanted.size() > BodySizes::masks_max) wanted.resize(BodySizes::masks_max);
  std::vector<FieldMask> masks;
  for (auto& item : wanted) masks.push_back(std::move(item.first));
  for (auto& [to, candidate] : candidates_) {
    const auto measured = [&](const FieldMask& mask) { return holds(masks, mask); };
    if (candidate.refusal.empty() && !std::ranges::all_of(candidate.masks, measured))
      candidate.refusal = "too many different masks";
  }
  if (possible < 2) {
    sizes_ = nullptr;
  } else if (sizes_ == nullptr || !std::ranges::is_permutation(sizes_->masks(), masks)) {
    sizes_ = std::make_shared<BodySizes>(*setup_.type, std::move(masks));
    counted_ = 0;
    counted_at_ = now;
  }
}

/// Whoever cannot be in a group any more is served alone from now on.
void GroupKeeper::keep_possible() {
  for (Planned& planned : planned_) {
    std::erase_if(planned.members, [&](const Destination* member) {
      const auto known = candidates_.find(member);
      return known == candidates_.end() || !known->second.refusal.empty();
    });
  }
  std::erase_if(planned_, [](const Planned& planned) { return planned.members.size() < 2; });
}

void GroupKeeper::merge(const Planned& planned, std::vector<RouteBundle>& routes) const {
  RouteBundle together{.wanted = {FieldMask(routes.front().wanted.mask.leaves()), 0}};
  together.multicast = planned.place;
  const auto is_member = [&](const Destination* to) { return holds(planned.members, to); };
  for (RouteBundle& bundle : routes) {
    if (bundle.multicast ||
        std::ranges::none_of(bundle.destinations, is_member, &std::shared_ptr<Destination>::get))
      continue;
    together.wanted.mask |= bundle.wanted.mask;
    std::erase_if(bundle.destinations, [&](const std::shared_ptr<Destination>& to) {
      if (!is_member(to.get())) return false;
      together.add(to);
      return true;
    });
    std::erase_if(bundle.readers, [&](const auto& reader) {
      if (!is_member(reader.second)) return false;
      together.readers.push_back(reader);
      return true;
    });
    std::erase_if(bundle.reliable, [&](const auto& item) {
      if (!is_member(item.first)) return false;
      together.reliable[item.first].insert(item.second.begin(), item.second.end());
      return true;
    });
  }
  routes.insert(routes.begin(), std::move(together));
}

std::shared_ptr<MulticastGroup> GroupKeeper::find(std::size_t place,
                                                  std::vector<MulticastGroup::Member> members) {
  const auto same = [&](const auto& group) { return group->members() == members && !group->broken(); };
  const auto known = std::ranges::find_if(groups_, same);
  if (known != groups_.end()) return found_.emplace_back(*known);
  std::size_t datagram_bytes = datagram_bytes_max;
  std::uint32_t receive_buffer_bytes = UINT32_MAX;
  for (const MulticastGroup::Member& member : members) {
    const Destination& to = member.lane->destination();
    datagram_bytes = std::min(datagram_bytes, to.path().datagram_bytes());
    receive_buffer_bytes = std::min(receive_buffer_bytes, to.window().receive_buffer_bytes());
  }
  const Candidate& candidate = candidates_.at(&members.front().lane->destination());
  const std::shared_ptr<Destination> to =
      setup_.connect(address(place), links_[*candidate.link].own, datagram_bytes);
  to->set_receive_buffer(receive_buffer_bytes);
  const MulticastGroup::Name name{setup_.writer, ++last_number_, address(place)};
  auto group = MulticastGroup::make(name, std::make_shared<Lane>(to, setup_.queue_depth, setup_.tally),
                                    std::move(members), setup_.report_port);
  setup_.roster->add(group);
  return found_.emplace_back(std::move(group));
}

void GroupKeeper::merged(Time now) {
  for (const auto& group : groups_) {
    if (!holds(found_, group)) retired_.push_back({group, now});
  }
  groups_ = std::exchange(found_, {});
  const core::Lock lock(why_mutex_);
  shown_ = groups_;
}

std::vector<PlanDestination> GroupKeeper::plan_destinations(std::vector<const Destination*>& places) const {
  std::vector<PlanDestination> destinations;
  for (const auto& [to, candidate] : candidates_) {
    if (!candidate.refusal.empty()) continue;
    PlanDestination& destination = destinations.emplace_back();
    for (std::size_t i = 0; i < sizes_->masks().size(); ++i) {
      if (holds(candidate.masks, sizes_->masks()[i])) destination.masks |= MaskSet{1} << i;
    }
    destination.link = *candidate.link;
    destination.datagram_bytes = to->path().datagram_bytes();
    destination.reliable = candidate.reliable;
    places.push_back(to);
  }
  return destinations;
}

bool GroupKeeper::replan(Time now) {
  if (std::ranges::any_of(groups_, [](const auto& group) { return group->broken(); })) return true;
  if (any_given_up(now)) return true;
  if (sizes_ != nullptr && sizes_->take_several()) {
    const bool is_news = now >= packed_until_;
    packed_until_ = now + packed_pause;
    if (is_news) return true;
  }
  if (sizes_ == nullptr || !sizes_->known() || now < replan_at_) return false;
  replan_at_ = now + replan_pause;
  const std::uint64_t samples = sizes_->samples();
  const std::chrono::duration<double> seconds = now - std::exchange(counted_at_, now);
  const double rate =
      static_cast<double>(samples - std::exchange(counted_, samples)) / std::max(seconds.count(), 0.1);

  std::vector<const Destination*> places;
  const std::vector<PlanDestination> destinations = plan_destinations(places);
  MulticastPlan present;
  for (const Planned& planned : planned_) {
    PlannedGroup& group = present.emplace_back();
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (!holds(planned.members, places[i])) continue;
      group.masks |= destinations[i].masks;
      group.members.push_back(i);
    }
  }
  const auto body_bytes = [this](MaskSet set) { return sizes_->bytes_of(set); };
  const MulticastPlan plan = plan_multicast(destinations, body_bytes, rate, present, setup_.limits);
  if (plan == present) return false;
  std::vector<Planned> next;
  for (const PlannedGroup& group : plan) {
    Planned planned{.place = next.size()};
    for (const std::size_t member : group.members) planned.members.push_back(places[member]);
    next.push_back(std::move(planned));
  }
  planned_ = std::move(next);
  return true;
}

bool GroupKeeper::any_given_up(Time now) {
  bool some = false;
  std::erase_if(deaf_until_, [&](const auto& item) { return item.second < now; });
  for (const auto& group : groups_) {
    for (const Destination* to : group->given_up()) {
      deaf_until_[to] = now + deaf_pause;
      some = true;
    }
  }
  return some;
}

/// 239.255.16.0 to 239.255.239.255, without those that others are known to use: two writers share one now and
/// then, and ignore what the other sends.
std::uint32_t GroupKeeper::address(std::size_t place) const {
  const std::uint32_t mixed = (setup_.writer + static_cast<std::uint32_t>(place)) * 2654435769U >> 16;
  return private_groups | (16 + (mixed >> 8) % 224) << 8 | (mixed & 0xff);
}

void GroupKeeper::tend(Time now) {
  for (const auto& group : groups_) {
    for (const MulticastGroup::Offer& offer : group->offers(now))
      send(group->members()[offer.member].lane->destination(), offer.offer, now);
  }
  std::erase_if(retired_, [&](const Retired& retired) {
    if (now - retired.at < farewell_after) return false;
    for (std::size_t i = 0; i < retired.group->members().size(); ++i)
      send(retired.group->members()[i].lane->destination(), retired.group->farewell(i), now);
    return true;
  });
}

void GroupKeeper::send(Destination& to, const GroupOffer& offer, Time now) {
  if (!to.takes_control(now)) return;
  std::array<std::byte, group_offer_bytes> bytes;
  encode(offer, bytes.data());
  to.note(send_one(to.connection(), bytes));
}

void GroupKeeper::explain(const std::vector<RouteBundle>& routes) {
  const core::Lock lock(why_mutex_);
  why_.clear();
  several_ = sizes_ != nullptr;
  for (const RouteBundle& bundle : routes) {
    for (const auto& [reader, to] : bundle.readers) why_[reader] = {to, candidates_.at(to).refusal};
  }
}

std::string GroupKeeper::why(core::EndpointId reader) const {
  const core::Lock lock(why_mutex_);
  const auto known = why_.find(reader);
  if (known == why_.end()) return {};
  const Why& why = known->second;
  if (!why.refusal.empty()) return "alone: " + why.refusal;
  for (const auto& group : shown_) {
    for (std::size_t i = 0; i < group->members().size(); ++i) {
      if (&group->members()[i].lane->destination() != why.to) continue;
      return "group " + core::format(core::IpAddress(group->name().address)) + " of " +
             std::to_string(group->members().size()) + group->state_of(i);
    }
  }
  return several_ ? "alone: a group would put hardly fewer bytes on the wire"
                  : "alone: nobody else could be in a group with it";
}

}  // namespace sft::udp
