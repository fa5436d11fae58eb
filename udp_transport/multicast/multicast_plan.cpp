#include "udp_transport/multicast/multicast_plan.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "udp_transport/multicast/one_copy.h"
#include "udp_transport/multicast/plan_search.h"

namespace sft::udp {

namespace {

bool are_alike(const PlanDestination& a, const PlanDestination& b) {
  return a.fields == b.fields && a.alone_bytes == b.alone_bytes && a.datagram_bytes == b.datagram_bytes;
}

/// The destinations of one division, by kind, and the plan for them.
class DivisionPlan {
 public:
  DivisionPlan(std::span<const PlanDestination> all, std::size_t division, const BodyBytes& body_bytes,
               const PlanLimits& limits)
      : all_(all), kinds_(kinds_of(division)), search_(kinds_, body_bytes, limits) {}

  /// Groups whose kinds are together at present. Those who came anew go where they cost least.
  void take_over(const MulticastPlan& present, double samples_per_s, const PlanLimits& limits) {
    places_.assign(kinds_.size(), PlanSearch::alone);
    std::map<std::size_t, std::size_t> place_of;  // by the place of the group in the present plan
    std::vector<std::size_t> newcomers;
    for (std::size_t kind = 0; kind < kinds_.size(); ++kind) {
      std::size_t group = PlanSearch::alone;
      bool is_new = false;
      for (const std::size_t member : members_[kind]) {
        const std::size_t here = group_of(present, member);
        is_new = is_new || all_[member].is_new;
        if (group == PlanSearch::alone) group = here;
      }
      if (is_new) newcomers.push_back(kind);
      if (group == PlanSearch::alone) continue;
      const std::size_t next = place_of.size();
      const std::size_t place = place_of.try_emplace(group, next).first->second;
      if (place < limits.groups_max) places_[kind] = place;
    }
    cost_ = search_.cost_of(places_);
    Places with_them = search_.insert(places_, newcomers);
    const PlanCost cost = search_.cost_of(with_them);
    if ((cost_.cost - cost.cost) * samples_per_s <= limits.gain_bytes_per_s) return;
    places_ = std::move(with_them);
    cost_ = cost;
  }

  /// Dissolves groups that are hardly worth anything any more. Who is in one of which nothing is heard for
  /// long may be forgotten by a switch, and then misses the next sample.
  void dissolve_if_rare(double samples_per_s, const PlanLimits& limits) {
    const Places all_alone(kinds_.size(), PlanSearch::alone);
    const PlanCost cost = search_.cost_of(all_alone);
    if ((cost.cost - cost_.cost) * samples_per_s >= limits.gain_bytes_per_s / 2) return;
    places_ = all_alone;
    cost_ = cost;
  }

  /// Changes whatever is worth it.
  void improve(double samples_per_s, const PlanLimits& limits) {
    Places best = search_.search(places_);
    const PlanCost least = search_.cost_of(best);
    const PlanCost gain = cost_ - least;
    const bool must = !search_.allows(cost_) && gain.wire * samples_per_s > limits.gain_bytes_per_s;
    const bool pays =
        gain.cost > limits.gain_min * least.cost && gain.cost * samples_per_s > limits.gain_bytes_per_s;
    if (must || pays) places_ = std::move(best);
  }

  void add_to(MulticastPlan& plan) const {
    std::map<std::size_t, PlannedGroup> groups;
    for (std::size_t kind = 0; kind < kinds_.size(); ++kind) {
      if (places_[kind] == PlanSearch::alone) continue;
      PlannedGroup& group = groups[places_[kind]];
      add_to_copy(group.fields, kinds_[kind].fields, group.members.empty());
      group.members.insert(group.members.end(), members_[kind].begin(), members_[kind].end());
    }
    for (auto& [place, group] : groups) {
      std::ranges::sort(group.members);
      if (group.members.size() > 1) plan.push_back(std::move(group));
    }
  }

 private:
  using Places = PlanSearch::Places;

  std::vector<PlanKind> kinds_of(std::size_t division) {
    std::vector<PlanKind> kinds;
    for (std::size_t i = 0; i < all_.size(); ++i) {
      const PlanDestination& to = all_[i];
      if (to.division != division) continue;
      const auto known = std::ranges::find_if(
          members_, [&](const auto& members) { return are_alike(all_[members.front()], to); });
      if (known == members_.end()) {
        members_.push_back({i});
        kinds.push_back({to.fields, to.alone_bytes, to.datagram_bytes, 1});
      } else {
        known->push_back(i);
        ++kinds[static_cast<std::size_t>(known - members_.begin())].destinations;
      }
    }
    return kinds;
  }

  static std::size_t group_of(const MulticastPlan& plan, std::size_t destination) {
    for (std::size_t i = 0; i < plan.size(); ++i) {
      if (std::ranges::binary_search(plan[i].members, destination)) return i;
    }
    return PlanSearch::alone;
  }

  const std::span<const PlanDestination> all_;
  std::vector<std::vector<std::size_t>> members_;  ///< of each kind
  const std::vector<PlanKind> kinds_;
  PlanSearch search_;
  Places places_;
  PlanCost cost_{};
};

}  // namespace

MulticastPlan plan_multicast(std::span<const PlanDestination> destinations, const BodyBytes& body_bytes,
                             double samples_per_s, const MulticastPlan& present, const PlanLimits& limits) {
  std::set<std::size_t> divisions;
  for (const PlanDestination& to : destinations) divisions.insert(to.division);
  MulticastPlan plan;
  for (const std::size_t division : divisions) {
    DivisionPlan one(destinations, division, body_bytes, limits);
    const std::optional<double> passing_per_s =
        std::ranges::find(destinations, division, &PlanDestination::division)->passing_per_s;
    const double here_per_s = passing_per_s.value_or(samples_per_s);
    one.take_over(present, here_per_s, limits);
    if (passing_per_s) one.dissolve_if_rare(here_per_s, limits);
    one.improve(here_per_s, limits);
    one.add_to(plan);
  }
  std::ranges::sort(plan, {}, [](const PlannedGroup& group) { return group.members.front(); });
  return plan;
}

std::vector<std::size_t> keep_places(const MulticastPlan& present, std::span<const std::size_t> places,
                                     const MulticastPlan& next) {
  constexpr std::size_t none = SIZE_MAX;
  std::vector<std::size_t> kept(next.size(), none);
  const auto keep_if = [&](const auto& is_successor) {
    for (std::size_t i = 0; i < next.size(); ++i) {
      for (std::size_t p = 0; p < present.size() && kept[i] == none; ++p) {
        const bool is_free = std::ranges::find(kept, places[p]) == kept.end();
        if (is_free && is_successor(present[p].members, next[i].members)) kept[i] = places[p];
      }
    }
  };
  keep_if([](const auto& before, const auto& now) { return before == now; });
  keep_if([](const auto& before, const auto& now) {
    return std::ranges::find_first_of(before, now) != before.end();
  });
  std::size_t unused = 0;
  for (std::size_t& place : kept) {
    if (place != none) continue;
    while (std::ranges::find(kept, unused) != kept.end()) ++unused;
    place = unused;
  }
  return kept;
}

}  // namespace sft::udp
