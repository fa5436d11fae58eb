#include "udp_transport/routing/group_keeper.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "udp_transport/io/interfaces.h"
#include "udp_transport/multicast/divisions.h"
#include "udp_transport/multicast/one_copy.h"

namespace sft::udp {

namespace {

/// The maximum number of leaves of a type that uses groups. For types with more leaves, only hashes of masks
/// are sent.
constexpr std::size_t leaves_in_groups_max = 64 * WireMask::words_max;

/// A size of a body that makes a group too expensive. It is greater than all real sizes, but small enough
/// for exact sums.
constexpr double too_much_body = 1e12;

constexpr const char* unsettled = "it asks for that only since just now, or often for something else";

template <class Range, class Value>
bool holds(const Range& range, const Value& value) {
  return std::ranges::find(range, value) != std::ranges::end(range);
}

}  // namespace

GroupKeeper::GroupKeeper(Setup setup)
    : setup_(std::move(setup)),
      too_many_leaves_(setup_.type->leaves() > leaves_in_groups_max),
      sharing_(setup_.limits) {}

void GroupKeeper::merge(std::vector<RouteBundle>& routes, Time now) {
  look_at(routes, now);
  choose_sizes(now);
  if (sizes_ != nullptr) sharing_.decide(*sizes_, now);
  keep_possible(now);
  hasten(now);
  if (may_plan(now)) plan(now);
  explain(routes, now);
  for (const Planned& planned : planned_) merge(planned, routes);
  sharing_.merge(routes);
  std::erase_if(routes, [](const RouteBundle& bundle) { return bundle.destinations.empty(); });
  std::ranges::stable_partition(routes, [](const RouteBundle& bundle) { return !bundle.fallback; });
  found_.clear();
}

void GroupKeeper::look_at(const std::vector<RouteBundle>& routes, Time now) {
  candidates_.clear();
  measured_.passing.forget_unused();
  links_ = setup_.use == Multicast::off ? std::vector<MulticastLink>{} : setup_.links(setup_.use);
  for (const RouteBundle& bundle : routes) look_at(bundle, now);
  const auto bytes_per_s = [&](const Candidate& candidate) {
    const BodySizes* const sizes = measured_.sizes.get();
    if (candidate.gate == nullptr || sizes == nullptr || !sizes->known_all(candidate.asked)) return 0.;
    return sizes->bytes_of(candidate.together) * measured_.passing.per_s(candidate.gate, now);
  };
  std::vector<Candidate*> possible;
  std::vector<DividedPlace> places;
  for (auto& [to, candidate] : candidates_) {
    if (!candidate.refusal.empty()) continue;
    possible.push_back(&candidate);
    const core::Wanted* const some_samples = candidate.some_samples ? &*candidate.some_samples : nullptr;
    places.push_back({*candidate.link, some_samples, is_planned(to, candidate), bytes_per_s(candidate)});
  }
  const std::vector<Division> divisions = divide(places);
  for (std::size_t i = 0; i < possible.size(); ++i) {
    possible[i]->division = divisions[i].number;
    possible[i]->refusal = divisions[i].refusal;
  }
  if (!too_many_leaves_) sharing_.look_at(routes);
  await_settled(now);
}

void GroupKeeper::look_at(const RouteBundle& bundle, Time now) {
  for (const std::shared_ptr<Destination>& to : bundle.destinations) {
    const auto [known, is_new] = candidates_.try_emplace(to.get());
    Candidate& candidate = known->second;
    if (is_new) candidate.to = to;
    if (is_new && bundle.gate != nullptr) {
      candidate.some_samples = bundle.wanted;
      candidate.gate = bundle.gate;
      measured_.passing.follow(bundle.gate, now);
    }
    if (is_new) choose_link(candidate, now);
    const Selection& asked = bundle.wanted.selection;
    const bool differ = !is_new && (candidate.some_samples || bundle.gate != nullptr);
    if (differ) candidate.refusal = "its readers ask for different samples, or for different fields of some";
    if (bundle.late_reader != 0) candidate.refusal = "a reader there is sent what was retained";
    if (bundle.fallback) candidate.refusal = "a reader there is served in shared memory";
    candidate.gets_more |= differ || bundle.late_reader != 0 || bundle.fallback;
    add_to_copy(candidate.together, asked, is_new);
    if (!holds(candidate.asked, asked)) candidate.asked.push_back(asked);
    candidate.reliable = candidate.reliable || bundle.reliable.contains(to.get());
  }
}

void GroupKeeper::await_settled(Time now) {
  settling_times_.begin_look();
  for (auto& [to, candidate] : candidates_) {
    const SocketAddress address = to->path().address();
    const std::uint32_t min_period_us = candidate.some_samples ? candidate.some_samples->min_period_us : 0;
    settling_times_.note(address, {candidate.asked, min_period_us, candidate.reliable, candidate.gets_more},
                         now);
    candidate.settled_at = settling_times_.settled_at(address);
  }
  settling_times_.end_look(now);
}

void GroupKeeper::choose_link(Candidate& candidate, Time now) const {
  const core::IpAddress address = candidate.to->path().address().ip;
  if (setup_.use == Multicast::off) candidate.refusal = "multicast is off by option";
  if (now < packed_until_ && !candidate.some_samples)
    candidate.refusal = "samples that are published together share datagrams";
  if (too_many_leaves_) candidate.refusal = "its type has too many fields";
  const auto unreached = unreached_until_.find(candidate.to.get());
  if (unreached != unreached_until_.end() && now < unreached->second)
    candidate.refusal = "no multicast comes to it";
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

std::size_t GroupKeeper::possible(Time now) const {
  return static_cast<std::size_t>(
      std::ranges::count_if(candidates_, [&](const auto& item) { return is_settled(item.second, now); }));
}

/// Starts or stops measuring the sizes of samples. They are measured even if only one destination may be in
/// a group, so that a plan can be made as soon as a second destination comes.
void GroupKeeper::choose_sizes(Time now) {
  const bool measures = std::exchange(sizes_, nullptr) != nullptr;
  if (possible(Time::max()) == 0 && !sharing_.is_possible()) return;
  if (measured_.sizes == nullptr) measured_.sizes = std::make_shared<BodySizes>(setup_.type->type());
  if (!measures) measured_.rate.emplace(now, measured_.sizes->samples());
  sizes_ = measured_.sizes;
  std::vector<Selection> asked;
  for (const auto& [to, candidate] : candidates_)
    asked.insert(asked.end(), candidate.asked.begin(), candidate.asked.end());
  sizes_->follow(*setup_.type, asked);
}

/// Removes destinations from the plan if they cannot be in a group any more, or have changed their request.
/// From now on, these destinations get their own copies.
void GroupKeeper::keep_possible(Time now) {
  const auto must_leave = [&](const Destination* to) {
    const auto known = candidates_.find(to);
    return known == candidates_.end() || !is_settled(known->second, now);
  };
  for (Planned& planned : planned_) std::erase_if(planned.members, must_leave);
  std::erase_if(planned_, [](const Planned& planned) { return planned.members.size() < 2; });
  if (std::erase_if(planned_for_.destinations, [&](const auto& item) { return must_leave(item.first); }) > 0)
    planned_for_.member_left = true;
}

void GroupKeeper::merge(const Planned& planned, std::vector<RouteBundle>& routes) const {
  RouteBundle together = take_out(routes, [&](const Destination* to) { return holds(planned.members, to); });
  together.multicast = planned.place;
  routes.insert(routes.begin(), std::move(together));
}

namespace {

/// Returns the maximum length of datagrams in bytes that the paths to all members carry, as far as it is
/// known.
std::size_t datagram_bytes_of(const std::vector<MulticastGroup::Member>& members) {
  std::size_t bytes = datagram_bytes_max;
  for (const MulticastGroup::Member& member : members)
    bytes = std::min(bytes, member.lane->destination().path().datagram_bytes());
  return bytes;
}

/// Returns true if the path to a member carries only shorter datagrams than were known when the group was
/// made.
bool is_too_long(const MulticastGroup& group) {
  return group.lane()->destination().path().datagram_bytes() > datagram_bytes_of(group.members());
}

}  // namespace

std::shared_ptr<MulticastGroup> GroupKeeper::find(std::size_t place,
                                                  std::vector<MulticastGroup::Member> members) {
  const auto same = [&](const auto& group) {
    return group->members() == members && !group->broken() && !is_too_long(*group);
  };
  const auto known = std::ranges::find_if(groups_, same);
  if (known != groups_.end()) return found_.emplace_back(*known);
  std::uint32_t receive_buffer_bytes = UINT32_MAX;
  for (const MulticastGroup::Member& member : members) {
    const Destination& to = member.lane->destination();
    receive_buffer_bytes = std::min(receive_buffer_bytes, to.window().receive_buffer_bytes());
  }
  const Candidate& candidate = candidates_.at(&members.front().lane->destination());
  const std::shared_ptr<Destination> to =
      setup_.connect(address(place), links_[*candidate.link].own, datagram_bytes_of(members));
  to->set_receive_buffer(receive_buffer_bytes);
  const MulticastGroup::Name name{setup_.writer, ++last_number_, address(place)};
  auto group = MulticastGroup::make(name, std::make_shared<Lane>(to, setup_.queue_depth, setup_.tally),
                                    std::move(members), setup_.report_port);
  setup_.registry->add(group);
  return found_.emplace_back(std::move(group));
}

void GroupKeeper::merged(Time now) {
  for (const auto& group : groups_) {
    if (!holds(found_, group)) farewells_.note(group, now);
  }
  groups_ = std::exchange(found_, {});
  reasons_.set_groups(groups_);
}

/// Returns true if the destination is in a group of the plan, and the same samples as before are for it.
bool GroupKeeper::is_planned(const Destination* to, const Candidate& candidate) const {
  return std::ranges::any_of(planned_, [&](const Planned& planned) {
    return planned.some_samples == candidate.some_samples && holds(planned.members, to);
  });
}

/// Returns the destinations that can be planned. Destinations with requested fields that no sample has had
/// yet are omitted, since the sizes of these fields are not known.
std::vector<PlanDestination> GroupKeeper::plan_destinations(std::vector<const Destination*>& places,
                                                            Time now) {
  std::vector<PlanDestination> destinations;
  for (const auto& [to, candidate] : candidates_) {
    if (!is_settled(candidate, now)) continue;
    if (!sizes_->known_all(candidate.asked)) {
      sizes_->measure_next();
      if (!is_planned(to, candidate)) continue;
    }
    const std::size_t datagram_bytes = to->path().datagram_bytes();
    const PlaceMark mark = candidate.reliable ? PlaceMark::in_channel : PlaceMark::none;
    const double alone = sharing_.bytes_to(to, candidate.asked, mark, *sizes_);
    PlanDestination& destination = destinations.emplace_back();
    destination = {candidate.together, alone, candidate.division, datagram_bytes};
    if (candidate.gate != nullptr) destination.passing_per_s = measured_.passing.per_s(candidate.gate, now);
    places.push_back(to);
  }
  return destinations;
}

bool GroupKeeper::replan(Time now) {
  if (std::ranges::any_of(groups_, [](const auto& group) { return group->broken() || is_too_long(*group); }))
    return true;
  if (any_given_up(now)) return true;
  if (sizes_ != nullptr && sizes_->take_several()) {
    const bool is_news = now >= packed_until_;
    packed_until_ = now + packed_pause;
    if (is_news) return true;
  }
  if (sizes_ != nullptr && sizes_->samples() == 0) measured_.rate.emplace(now);
  const bool is_shared_otherwise = sizes_ != nullptr && sharing_.decide(*sizes_, now);
  const bool came = member_came(now);
  hasten(now);
  if (!may_plan(now)) return is_shared_otherwise;
  const bool is_better = plan(now) || is_shared_otherwise;
  return is_better || (came && !member_came(now));  // if a new member came, why() must return a new text
}

/// Returns true if a destination is new, or requests other fields than before. Destinations with requested
/// fields that no sample has had yet do not count.
bool GroupKeeper::member_came(Time now) const {
  return sizes_ != nullptr && std::ranges::any_of(candidates_, [&](const auto& item) {
           const auto known = planned_for_.destinations.find(item.first);
           const bool is_new =
               known == planned_for_.destinations.end() || known->second.fields != item.second.together;
           return is_new && is_settled(item.second, now) && sizes_->known_all(item.second.asked);
         });
}

/// Makes replan() plan soon if a destination is new.
void GroupKeeper::hasten(Time now) {
  if (member_came(now)) replan_at_ = std::min(replan_at_, std::max(now, planned_at_ + settling));
}

/// Returns true if a plan can be made now. For a plan, at least one sample must have been published, so that
/// sizes are known.
bool GroupKeeper::may_plan(Time now) const {
  return sizes_ != nullptr && sizes_->samples() > 0 && now >= replan_at_ && possible(now) > 1;
}

/// Returns false if the present plan was made for the same destinations, and for about the same bytes and
/// rates.
bool GroupKeeper::is_news(std::span<const Destination* const> places,
                          std::span<const PlanDestination> all) const {
  const auto differ = [](double before, double now, double least = 0.01) {
    return std::abs(now - before) > least * before;
  };
  constexpr double of_rates = 0.25;  // tolerance of rates, which vary from second to second
  const auto& before = planned_for_.destinations;
  if (planned_for_.member_left || places.size() != before.size()) return true;
  if (differ(planned_for_.samples_per_s, measured_.rate->per_s(), of_rates)) return true;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto known = before.find(places[i]);
    if (known == before.end() || known->second.fields != all[i].fields ||
        known->second.division != all[i].division || differ(known->second.alone_bytes, all[i].alone_bytes) ||
        differ(known->second.passing_per_s.value_or(0), all[i].passing_per_s.value_or(0), of_rates))
      return true;
  }
  return false;
}

/// Makes a plan. Returns true if other groups are better than the present ones.
bool GroupKeeper::plan(Time now) {
  measured_.rate->count(sizes_->samples(), now);
  replan_at_ = measured_.rate->due(now + replan_pause);
  std::vector<const Destination*> places;
  const std::vector<PlanDestination> destinations = plan_destinations(places, now);
  MulticastPlan present;
  for (const Planned& planned : planned_) {
    PlannedGroup& group = present.emplace_back();
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (!holds(planned.members, places[i])) continue;
      add_to_copy(group.fields, destinations[i].fields, group.members.empty());
      group.members.push_back(i);
    }
  }
  if (!is_news(places, destinations)) return false;
  planned_for_ = {.samples_per_s = measured_.rate->per_s()};
  for (std::size_t i = 0; i < places.size(); ++i)
    planned_for_.destinations.emplace(places[i], destinations[i]);
  const auto is_asked_for = [&](const Selection& sent) {
    return std::ranges::any_of(candidates_, [&](const auto& item) { return holds(item.second.asked, sent); });
  };
  const auto body_bytes = [&](const Selection& sent) {
    const double bytes = sizes_->bytes_of(sent);
    const bool may_be_sent = bytes <= setup_.limits.merged_body_max || is_asked_for(sent);
    return may_be_sent ? bytes : too_much_body;
  };
  const MulticastPlan plan =
      plan_multicast(destinations, body_bytes, measured_.rate->per_s(), present, setup_.limits);
  if (std::ranges::is_permutation(plan, present)) return false;
  std::vector<std::size_t> present_places;
  for (const Planned& planned : planned_) present_places.push_back(planned.place);
  const std::vector<std::size_t> next_places = keep_places(present, present_places, plan);
  std::vector<Planned> next;
  for (const PlannedGroup& group : plan) {
    Planned planned{.place = next_places[next.size()],
                    .some_samples = candidates_.at(places[group.members.front()]).some_samples};
    for (const std::size_t member : group.members) planned.members.push_back(places[member]);
    next.push_back(std::move(planned));
  }
  planned_ = std::move(next);
  planned_at_ = now;
  return true;
}

bool GroupKeeper::any_given_up(Time now) {
  bool some = false;
  std::erase_if(unreached_until_, [&](const auto& item) { return item.second < now; });
  for (const auto& group : groups_) {
    for (const Destination* to : group->given_up()) {
      unreached_until_[to] = now + unreached_pause;
      some = true;
    }
  }
  return some;
}

/// Returns an address from 239.255.16.0 to 239.255.239.255, a range without the addresses that other
/// software is known to use. Two writers may share an address by chance. Then receivers ignore the samples
/// of a writer that they do not read.
std::uint32_t GroupKeeper::address(std::size_t place) const {
  const std::uint32_t mixed = (setup_.writer + static_cast<std::uint32_t>(place)) * 2654435769U >> 16;
  return private_groups | (16 + (mixed >> 8) % 224) << 8 | (mixed & 0xff);
}

void GroupKeeper::maintain(Time now) {
  for (const auto& group : groups_) {
    for (const MulticastGroup::Offer& offer : group->offers(now))
      send(group->members()[offer.member].lane->destination(), offer.offer, now);
    if (const std::optional<GroupProbe> probe = group->probe(now)) send(*group, *probe);
  }
  farewells_.say(now, [now](Destination& to, const GroupOffer& offer) { send(to, offer, now); });
}

void GroupKeeper::send(Destination& to, const GroupOffer& offer, Time now) {
  if (!to.takes_control(now)) return;
  std::array<std::byte, group_offer_bytes> bytes;
  encode(offer, bytes.data());
  to.note(send_one(to.connection(), bytes));
}

void GroupKeeper::send(MulticastGroup& to, const GroupProbe& probe) {
  Destination& group = to.lane()->destination();
  std::array<std::byte, group_probe_bytes> bytes;
  encode(probe, bytes.data());
  group.note(send_one(group.connection(), bytes));
}

GroupKeeper::Time GroupKeeper::next_duty(Time now) const {
  Time next = Time::max();
  for (const auto& group : groups_) next = std::min(next, group->next_probe());
  if (sizes_ == nullptr || sizes_->samples() == 0) return next;
  if (sharing_.is_undecided(*sizes_)) return now;
  if (possible(Time::max()) < 2) return next;
  for (const auto& [to, candidate] : candidates_) {
    if (candidate.refusal.empty() && candidate.settled_at > now) next = std::min(next, candidate.settled_at);
  }
  const bool will_plan = possible(now) > 1 && member_came(now);
  return will_plan ? std::min(next, std::max(replan_at_, now)) : next;
}

void GroupKeeper::explain(const std::vector<RouteBundle>& routes, Time now) {
  GroupReasons::Readers readers;
  std::map<std::size_t, std::size_t> possible_in;  // number of possible members by division
  for (const auto& [to, candidate] : candidates_)
    if (candidate.refusal.empty()) ++possible_in[candidate.division];
  for (const RouteBundle& bundle : routes) {
    for (const auto& [reader, to] : bundle.readers) {
      const Candidate& candidate = candidates_.at(to);
      const bool has_company = candidate.refusal.empty() && possible_in[candidate.division] > 1;
      const bool waits = has_company && !is_settled(candidate, now);
      const Selection& asked = bundle.wanted.selection;
      readers[reader] = {to,
                         waits ? unsettled : candidate.refusal,
                         asked,
                         sizes_ == nullptr ? nullptr : sizes_->part_size(asked),
                         sharing_.shares(to),
                         has_company};
    }
  }
  reasons_.set_readers(std::move(readers), sizes_);
}

}  // namespace sft::udp
