#include "udp_transport/multicast/plan_search.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <numeric>
#include <ranges>
#include <utility>

#include "udp_transport/multicast/all_partitions.h"
#include "udp_transport/multicast/one_copy.h"

namespace sft::udp {

namespace {

/// A byte too much on the wire counts so many times while a partition takes shape, and in the end: then no
/// cost outweighs it.
constexpr double excess_weight_at_first = 2, excess_weight_at_last = 1e9;
constexpr double excess_least = 1e-6;
constexpr double unknown = -1;

/// Less is a rounding error.
bool is_less(double a, double b) { return a < b - 1e-6 - 1e-12 * b; }

}  // namespace

PlanSearch::PlanSearch(std::span<const PlanKind> kinds, const BodyBytes& body_bytes, const PlanLimits& limits)
    : kinds_(kinds), body_bytes_(body_bytes), limits_(limits), by_size_(kinds.size()) {
  std::iota(by_size_.begin(), by_size_.end(), 0);
  std::ranges::stable_sort(by_size_, std::greater{}, [&](std::size_t i) { return kinds_[i].alone_bytes; });
  const double apart = cost_of(Places(kinds_.size(), alone)).wire;
  wire_max_ = limits_.wire_max * std::min(apart, cost_of(Places(kinds_.size(), 0)).wire);
}

PlanCost PlanSearch::alone_cost(std::size_t kind) const {
  const double bytes = static_cast<double>(kinds_[kind].destinations) * kinds_[kind].alone_bytes;
  return {bytes, bytes};
}

/// One destination is no group.
void PlanSearch::weigh(Group& group, double known_together) const {
  group.cost = {};
  if (group.destinations < 2) {
    group.together = unknown;
    for (const std::size_t kind : group.kinds) group.cost = group.cost + alone_cost(kind);
    return;
  }
  group.together = known_together;
  if (known_together == unknown)
    group.together = wire_bytes(body_bytes_(group.fields), group.datagram_bytes, PlaceMark::in_group);
  group.cost = {group.together, group.together};
  for (const std::size_t kind : group.kinds) {
    const double unwanted = std::max(0.0, group.together - kinds_[kind].alone_bytes);
    group.cost.cost += limits_.unwanted_weight * static_cast<double>(kinds_[kind].destinations) * unwanted;
  }
}

PlanSearch::Group PlanSearch::with(const Group& group, std::size_t kind) const {
  Group one;
  one.kinds = {kind};
  one.fields = kinds_[kind].fields;
  one.datagram_bytes = kinds_[kind].datagram_bytes;
  one.destinations = kinds_[kind].destinations;
  one.together = unknown;
  return united(group, one);
}

/// Bytes are counted again only if more fields or shorter datagrams are sent than before.
PlanSearch::Group PlanSearch::united(Group group, const Group& other) const {
  Selection fields = group.fields;
  add_to_copy(fields, other.fields, group.kinds.empty());
  const bool is_same =
      group.destinations > 1 && fields == group.fields && group.datagram_bytes <= other.datagram_bytes;
  group.fields = std::move(fields);
  group.datagram_bytes = std::min(group.datagram_bytes, other.datagram_bytes);
  group.destinations += other.destinations;
  group.kinds.insert(group.kinds.end(), other.kinds.begin(), other.kinds.end());
  weigh(group, is_same ? group.together : unknown);
  return group;
}

PlanSearch::Group PlanSearch::without(const Group& group, std::size_t kind) const {
  Group rest;
  for (const std::size_t other : group.kinds) {
    if (other == kind) continue;
    add_to_copy(rest.fields, kinds_[other].fields, rest.kinds.empty());
    rest.kinds.push_back(other);
    rest.datagram_bytes = std::min(rest.datagram_bytes, kinds_[other].datagram_bytes);
    rest.destinations += kinds_[other].destinations;
  }
  const bool is_same = rest.fields == group.fields && rest.datagram_bytes == group.datagram_bytes;
  weigh(rest, is_same ? group.together : unknown);
  return rest;
}

double PlanSearch::judge(PlanCost cost) const {
  const double excess = cost.wire - wire_max_;
  return excess <= excess_least ? cost.cost : cost.cost + excess_weight_ * (1 + excess);
}

void PlanSearch::begin(const Places& places) {
  places_ = places;
  groups_.assign(limits_.groups_max, {});
  cost_ = {};
  for (std::size_t kind = 0; kind < places_.size(); ++kind) {
    if (places_[kind] == alone) {
      cost_ = cost_ + alone_cost(kind);
      continue;
    }
    Group& group = groups_[places_[kind]];
    add_to_copy(group.fields, kinds_[kind].fields, group.kinds.empty());
    group.kinds.push_back(kind);
    group.datagram_bytes = std::min(group.datagram_bytes, kinds_[kind].datagram_bytes);
    group.destinations += kinds_[kind].destinations;
  }
  for (Group& group : groups_) {
    weigh(group, unknown);
    cost_ = cost_ + group.cost;
  }
}

PlanCost PlanSearch::cost_of(const Places& places) {
  begin(places);
  return cost_;
}

/// Puts the kind where it costs least: alone, into a group, or into the first empty group, in which others
/// may join it.
bool PlanSearch::settle(std::size_t kind) {
  const std::size_t from = places_[kind];
  const Group rest = from == alone ? Group{} : without(groups_[from], kind);
  const PlanCost elsewhere =
      from == alone ? cost_ - alone_cost(kind) : cost_ - groups_[from].cost + rest.cost;
  double least = judge(cost_);
  std::size_t to = from;
  Group joined;
  const auto consider = [&](std::size_t place, PlanCost cost, Group group) {
    if (!is_less(judge(cost), least)) return;
    least = judge(cost);
    to = place;
    joined = std::move(group);
  };
  if (from != alone) consider(alone, elsewhere + alone_cost(kind), {});
  bool tried_empty = false;
  for (std::size_t place = 0; place < groups_.size(); ++place) {
    if (place == from || (groups_[place].kinds.empty() && std::exchange(tried_empty, true))) continue;
    Group group = with(groups_[place], kind);
    consider(place, elsewhere - groups_[place].cost + group.cost, std::move(group));
  }
  if (to == from) return false;
  if (from != alone) groups_[from] = rest;
  cost_ = elsewhere;
  if (to == alone) {
    cost_ = cost_ + alone_cost(kind);
  } else {
    cost_ = cost_ - groups_[to].cost + joined.cost;
    groups_[to] = std::move(joined);
  }
  places_[kind] = to;
  return true;
}

bool PlanSearch::move_one_by_one() {
  bool any = false;
  for (const std::size_t kind : by_size_) any = settle(kind) || any;
  return any;
}

bool PlanSearch::dissolve_groups() {
  bool any = false;
  for (Group& group : groups_) {
    if (group.kinds.empty()) continue;
    PlanCost cost = cost_ - group.cost;
    for (const std::size_t kind : group.kinds) cost = cost + alone_cost(kind);
    if (!is_less(judge(cost), judge(cost_))) continue;
    for (const std::size_t kind : group.kinds) places_[kind] = alone;
    cost_ = cost;
    group = {};
    any = true;
  }
  return any;
}

bool PlanSearch::unite_groups() {
  bool any = false;
  for (std::size_t to = 0; to < groups_.size(); ++to) {
    for (std::size_t from = 0; from < groups_.size(); ++from) {
      if (from == to || groups_[from].kinds.empty() || groups_[to].kinds.empty()) continue;
      Group both = united(groups_[to], groups_[from]);
      const PlanCost cost = cost_ - groups_[to].cost - groups_[from].cost + both.cost;
      if (!is_less(judge(cost), judge(cost_))) continue;
      for (const std::size_t kind : groups_[from].kinds) places_[kind] = to;
      cost_ = cost;
      groups_[to] = std::move(both);
      groups_[from] = {};
      any = true;
    }
  }
  return any;
}

/// Makes a group of two that are alone. Each is tried with a few others of about its size.
bool PlanSearch::pair_up() {
  bool any = false;
  for (std::size_t i = 0; i < by_size_.size(); ++i) {
    const auto empty = std::ranges::find_if(groups_, [](const Group& group) { return group.kinds.empty(); });
    if (empty == groups_.end()) return any;
    if (places_[by_size_[i]] != alone) continue;
    const Group one = with({}, by_size_[i]);
    double least = judge(cost_);
    Group best;
    PlanCost cost_then;
    std::size_t tried = 0;
    for (std::size_t j = i + 1; j < by_size_.size() && tried < partners_max; ++j) {
      if (places_[by_size_[j]] != alone) continue;
      ++tried;
      Group pair = with(one, by_size_[j]);
      const PlanCost cost = cost_ - alone_cost(by_size_[i]) - alone_cost(by_size_[j]) + pair.cost;
      if (!is_less(judge(cost), least)) continue;
      least = judge(cost);
      best = std::move(pair);
      cost_then = cost;
    }
    if (best.kinds.empty()) continue;
    for (const std::size_t kind : best.kinds)
      places_[kind] = static_cast<std::size_t>(empty - groups_.begin());
    *empty = std::move(best);
    cost_ = cost_then;
    any = true;
  }
  return any;
}

/// The number of rounds keeps planning near to O(kinds log kinds). More than a few are seldom needed.
void PlanSearch::improve() {
  for (auto rounds = 4 + std::bit_width(kinds_.size()); rounds > 0; --rounds) {
    bool any = move_one_by_one();
    any = dissolve_groups() || any;
    any = unite_groups() || any;
    any = pair_up() || any;
    if (!any) break;
  }
}

/// Twice: the way to a good partition may lead over some that put too much on the wire, or may not.
void PlanSearch::improve_from(const Places& places) {
  excess_weight_ = excess_weight_at_first;
  begin(places);
  improve();
  excess_weight_ = excess_weight_at_last;
  improve();
  keep_if_best();
  begin(places);
  improve();
  keep_if_best();
}

void PlanSearch::keep_if_best() {
  if (judge(cost_) >= best_judged_) return;
  best_judged_ = judge(cost_);
  best_ = places_;
}

PlanSearch::Places PlanSearch::insert(const Places& places, std::span<const std::size_t> newcomers) {
  excess_weight_ = excess_weight_at_last;
  begin(places);
  for (const std::size_t kind : newcomers) settle(kind);
  return places_;
}

/// Each kind, the largest first, begins a group of its own as long as there is room, or joins one.
PlanSearch::Places PlanSearch::seeded(std::span<const std::size_t> order) {
  begin(Places(kinds_.size(), alone));
  std::size_t used = 0;
  for (const std::size_t kind : order) {
    if (settle(kind) || used == groups_.size()) continue;
    const auto empty = std::ranges::find_if(groups_, [](const Group& group) { return group.kinds.empty(); });
    if (empty == groups_.end()) continue;
    *empty = with({}, kind);
    places_[kind] = static_cast<std::size_t>(empty - groups_.begin());
  }
  return places_;
}

/// Two groups: the larger kinds and the smaller ones, where that costs least.
PlanSearch::Places PlanSearch::cut_by_size() const {
  std::vector<PlanCost> larger, smaller;  // of the first or the last i kinds
  const auto weigh_ever_more = [&](const auto& order, std::vector<PlanCost>& costs) {
    Group group;
    costs.push_back({});
    for (const std::size_t kind : order) {
      group = with(group, kind);
      costs.push_back(group.cost);
    }
  };
  weigh_ever_more(by_size_, larger);
  weigh_ever_more(std::ranges::reverse_view(by_size_), smaller);
  Places best(kinds_.size(), 0);
  double least = std::numeric_limits<double>::infinity();
  std::size_t cut = 0;
  for (std::size_t i = 0; i <= kinds_.size(); ++i) {
    const double judged = judge(larger[i] + smaller[kinds_.size() - i]);
    if (judged >= least) continue;
    least = judged;
    cut = i;
  }
  for (std::size_t i = cut; i < kinds_.size(); ++i) best[by_size_[i]] = 1;
  return best;
}

/// Of so few kinds all partitions are tried. The bytes of each set of them are counted once.
PlanSearch::Places PlanSearch::try_all() const {
  std::vector<PlanCost> apart, together{{}};
  std::vector<Group> groups(1);
  for (std::size_t kind = 0; kind < kinds_.size(); ++kind) apart.push_back(alone_cost(kind));
  for (std::size_t set = 1; set < std::size_t{1} << kinds_.size(); ++set) {
    groups.push_back(with(groups[set & (set - 1)], static_cast<std::size_t>(std::countr_zero(set))));
    together.push_back(groups.back().cost);
  }
  static_assert(alone == AllPartitions::alone);
  return AllPartitions(apart, together, limits_.groups_max).best([&](PlanCost cost) { return judge(cost); });
}

PlanSearch::Places PlanSearch::search(const Places& present) {
  excess_weight_ = excess_weight_at_last;
  return kinds_.size() <= exact_max ? try_all() : look_from(present);
}

/// Looks in the neighbourhood of several partitions.
PlanSearch::Places PlanSearch::look_from(const Places& present) {
  excess_weight_ = excess_weight_at_last;
  best_judged_ = std::numeric_limits<double>::infinity();
  begin(present);
  keep_if_best();
  improve_from(present);
  improve_from(Places(kinds_.size(), alone));
  improve_from(Places(kinds_.size(), 0));
  improve_from(seeded(by_size_));
  std::vector<std::size_t> smallest_first(by_size_.rbegin(), by_size_.rend());
  improve_from(seeded(smallest_first));
  if (limits_.groups_max > 1) improve_from(cut_by_size());
  return best_;
}

}  // namespace sft::udp
