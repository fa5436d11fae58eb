#include "udp_transport/multicast/multicast_plan.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "udp_transport/wire/datagram.h"

namespace sft::udp {

namespace {

constexpr double lower_header_bytes = 14 + 20 + 8;  // Ethernet, IPv4, UDP: what interfaces count

double alone_cost(const PlanDestination& to, const BodyBytes& body_bytes) {
  const PlaceMark place = to.reliable ? PlaceMark::in_channel : PlaceMark::none;
  double cost = 0;
  for (MaskSet left = to.masks; left != 0; left &= left - 1)
    cost += wire_bytes(body_bytes(left & -left), to.datagram_bytes, place);
  return cost;
}

std::vector<double> alone_costs(std::span<const PlanDestination> destinations, const BodyBytes& body_bytes) {
  std::vector<double> costs;
  for (const PlanDestination& to : destinations) costs.push_back(alone_cost(to, body_bytes));
  return costs;
}

/// `alone`: of each destination. Always with a mark.
double cost_of(std::span<const PlanDestination> destinations, const std::vector<double>& alone,
               const BodyBytes& body_bytes, const MulticastPlan& plan, const PlanLimits& limits) {
  double cost = std::accumulate(alone.begin(), alone.end(), 0.0);
  for (const PlannedGroup& group : plan) {
    std::size_t datagram_bytes = SIZE_MAX;
    for (const std::size_t member : group.members)
      datagram_bytes = std::min(datagram_bytes, destinations[member].datagram_bytes);
    const double together = wire_bytes(body_bytes(group.masks), datagram_bytes, PlaceMark::in_group);
    cost += together;
    for (const std::size_t member : group.members)
      cost += limits.unwanted_weight * std::max(0.0, together - alone[member]) - alone[member];
  }
  return cost;
}

/// Destinations with the same masks behind the same link, which are treated alike. (To split them would only
/// ever pay where one of them gives a group its second member, so that another one gets its several masks at
/// once.)
struct Kind {
  MaskSet masks = 0;
  std::size_t link = 0;
  std::vector<std::size_t> members{};
};

std::vector<Kind> kinds_of(std::span<const PlanDestination> destinations, std::size_t most) {
  std::map<std::pair<std::size_t, MaskSet>, Kind> by_masks;
  for (std::size_t i = 0; i < destinations.size(); ++i) {
    const PlanDestination& to = destinations[i];
    Kind& kind = by_masks.try_emplace({to.link, to.masks}, Kind{to.masks, to.link}).first->second;
    kind.members.push_back(i);
  }
  std::vector<Kind> kinds;
  for (auto& [masks, kind] : by_masks) kinds.push_back(std::move(kind));
  std::ranges::stable_sort(kinds, std::greater{}, [](const Kind& kind) { return kind.members.size(); });
  if (kinds.size() > most) kinds.resize(most);
  return kinds;
}

/// Tries each way to put kinds into groups, or alone.
class Search {
 public:
  Search(std::span<const PlanDestination> destinations, const BodyBytes& body_bytes, const PlanLimits& limits)
      : destinations_(destinations),
        body_bytes_(body_bytes),
        limits_(limits),
        kinds_(kinds_of(destinations, limits.kinds_max)),
        alone_(alone_costs(destinations, body_bytes)) {}

  MulticastPlan best() {
    best_cost_ = cost_of(destinations_, alone_, body_bytes_, {}, limits_);
    place(0);
    for (PlannedGroup& group : best_) std::ranges::sort(group.members);
    std::ranges::sort(best_, {}, [](const PlannedGroup& group) { return group.members.front(); });
    return best_;
  }

 private:
  void place(std::size_t next) {
    if (next == kinds_.size()) return weigh();
    place(next + 1);  // alone
    const Kind& kind = kinds_[next];
    for (std::size_t i = 0; i < plan_.size(); ++i) {
      if (destinations_[plan_[i].members.front()].link != kind.link) continue;
      const PlannedGroup before = plan_[i];
      plan_[i].masks |= kind.masks;
      plan_[i].members.insert(plan_[i].members.end(), kind.members.begin(), kind.members.end());
      place(next + 1);
      plan_[i] = before;
    }
    if (plan_.size() == limits_.groups_max) return;
    plan_.push_back({kind.masks, kind.members});
    place(next + 1);
    plan_.pop_back();
  }

  void weigh() {
    if (std::ranges::any_of(plan_, [](const PlannedGroup& group) { return group.members.size() < 2; }))
      return;
    const double cost = cost_of(destinations_, alone_, body_bytes_, plan_, limits_);
    if (cost >= best_cost_) return;
    best_cost_ = cost;
    best_ = plan_;
  }

  const std::span<const PlanDestination> destinations_;
  const BodyBytes& body_bytes_;
  const PlanLimits& limits_;
  const std::vector<Kind> kinds_;
  const std::vector<double> alone_;
  MulticastPlan plan_, best_;
  double best_cost_ = 0;
};

}  // namespace

double wire_bytes(double body_bytes, std::size_t datagram_bytes, PlaceMark place) {
  const bool is_whole = body_bytes + first_header_bytes <= static_cast<double>(datagram_bytes);
  const bool has_mark = place == PlaceMark::in_group || (place == PlaceMark::in_channel && !is_whole);
  const double mark = has_mark ? group_bytes : 0;
  const double all = body_bytes + static_cast<double>(first_header_bytes - following_header_bytes) + mark;
  const auto room = static_cast<double>(datagram_bytes - following_header_bytes);
  const double datagrams = std::max(1.0, std::ceil(all / room));
  return all + datagrams * (static_cast<double>(following_header_bytes) + lower_header_bytes);
}

double plan_cost(std::span<const PlanDestination> destinations, const BodyBytes& body_bytes,
                 const MulticastPlan& plan, const PlanLimits& limits) {
  return cost_of(destinations, alone_costs(destinations, body_bytes), body_bytes, plan, limits);
}

MulticastPlan plan_multicast(std::span<const PlanDestination> destinations, const BodyBytes& body_bytes,
                             double samples_per_s, const MulticastPlan& present, const PlanLimits& limits) {
  const double before = plan_cost(destinations, body_bytes, present, limits);
  MulticastPlan best = Search(destinations, body_bytes, limits).best();
  const double gain = before - plan_cost(destinations, body_bytes, best, limits);
  const bool worth_it = gain > limits.gain_min * before && gain * samples_per_s > limits.gain_bytes_per_s;
  return worth_it ? best : present;
}

}  // namespace sft::udp
