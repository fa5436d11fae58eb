#include "udp_transport/multicast/multicast_plan.h"

#include <algorithm>
#include <functional>
#include <set>
#include <utility>

#include "udp_transport/multicast/one_copy.h"

namespace sft::udp {

namespace {

/// Destinations that share one copy, or one destination that gets its own copy.
struct Share {
  Selection fields{};
  std::vector<std::size_t> members{};
  PlanCost cost{};
  bool is_group() const { return members.size() > 1; }
};

PlanCost cost_of(std::span<const Share> shares) {
  PlanCost sum;
  for (const Share& share : shares) sum = sum + share.cost;
  return sum;
}

/// The plan for the destinations of one division.
class DivisionPlan {
 public:
  DivisionPlan(std::span<const PlanDestination> all, std::size_t division, const BodyBytes& body_bytes,
               const PlanLimits& limits)
      : all_(all), body_bytes_(body_bytes), limits_(limits), equals_(equals_in(division)) {
    std::vector<std::size_t> everyone;
    for (const auto& members : equals_) {
      everyone.insert(everyone.end(), members.begin(), members.end());
      for (const std::size_t member : members) alone_.push_back(alone(member));
    }
    everyone_ = everyone.size() > 1 ? together(std::move(everyone)) : alone_.front();
    wire_max_ = limits_.wire_max * std::min(cost_of(alone_).wire, everyone_.cost.wire);
  }

  /// Begins with the present groups. A new destination joins the group of a destination with the same
  /// request.
  void take_over(const MulticastPlan& present) {
    std::vector<std::vector<std::size_t>> groups(present.size());
    for (const auto& members : equals_) {
      const auto is_in = [&](const PlannedGroup& group) {
        return std::ranges::find_first_of(members, group.members) != members.end();
      };
      const auto group = std::ranges::find_if(present, is_in);
      if (group == present.end()) {
        for (const std::size_t member : members) shares_.push_back(alone(member));
      } else {
        auto& all = groups[static_cast<std::size_t>(group - present.begin())];
        all.insert(all.end(), members.begin(), members.end());
      }
    }
    for (auto& members : groups) {
      if (members.size() == 1) shares_.push_back(alone(members.front()));
      if (members.size() > 1) shares_.push_back(together(std::move(members)));
    }
  }

  /// Dissolves all groups if they save only a few bytes per second. A switch may discard the members of a
  /// group without traffic, and these members would then miss the next sample.
  void dissolve_if_rare(double samples_per_s) {
    const double gain = cost_of(alone_).cost - cost_of(shares_).cost;
    if (gain * samples_per_s < limits_.gain_bytes_per_s / 2) shares_ = alone_;
  }

  /// Changes to a better plan if its gain exceeds the limits.
  void improve(double samples_per_s) {
    std::vector<Share> better = share_where_equal();
    if (cost_of(better).wire > limits_.wire_max * everyone_.cost.wire) better = unite(std::move(better));
    const PlanCost present = cost_of(shares_), next = cost_of(better), gain = present - next;
    const bool must = present.wire > wire_max_ && gain.wire * samples_per_s > limits_.gain_bytes_per_s;
    const bool pays =
        gain.cost > limits_.gain_min * next.cost && gain.cost * samples_per_s > limits_.gain_bytes_per_s;
    if (must || pays) shares_ = std::move(better);
  }

  void add_to(MulticastPlan& plan) const {
    for (const Share& share : shares_) {
      if (!share.is_group()) continue;
      plan.push_back({share.fields, share.members});
      std::ranges::sort(plan.back().members);
    }
  }

 private:
  /// Returns the destinations of the division, one list for each set of fields.
  std::vector<std::vector<std::size_t>> equals_in(std::size_t division) const {
    std::vector<std::vector<std::size_t>> equals;
    for (std::size_t i = 0; i < all_.size(); ++i) {
      if (all_[i].division != division) continue;
      const auto known = std::ranges::find_if(
          equals, [&](const auto& members) { return all_[members.front()].fields == all_[i].fields; });
      known == equals.end() ? equals.push_back({i}) : known->push_back(i);
    }
    return equals;
  }

  Share alone(std::size_t destination) const {
    const PlanDestination& to = all_[destination];
    return {to.fields, {destination}, {to.alone_bytes, to.alone_bytes}};
  }

  Share together(std::vector<std::size_t> members) const {
    Share share{.members = std::move(members)};
    std::size_t datagram_bytes = SIZE_MAX;
    for (const std::size_t member : share.members) {
      add_to_copy(share.fields, all_[member].fields, member == share.members.front());
      datagram_bytes = std::min(datagram_bytes, all_[member].datagram_bytes);
    }
    const double bytes = wire_bytes(body_bytes_(share.fields), datagram_bytes, PlaceMark::in_group);
    share.cost = {bytes, bytes};
    for (const std::size_t member : share.members)
      share.cost.cost += limits_.unwanted_weight * std::max(0.0, bytes - all_[member].alone_bytes);
    return share;
  }

  /// Makes a group for each selection that several destinations request, if one copy has fewer bytes than
  /// separate copies. If there are too many groups, those that save the most bytes are kept.
  std::vector<Share> share_where_equal() const {
    struct Candidate {
      Share group;
      double saved = 0;
    };
    std::vector<Candidate> groups;
    std::vector<Share> shares;
    const auto serve_alone = [&](const std::vector<std::size_t>& members) {
      for (const std::size_t member : members) shares.push_back(alone(member));
    };
    for (const auto& members : equals_) {
      if (members.size() < 2) {
        serve_alone(members);
        continue;
      }
      Share group = together(members);
      double saved = -group.cost.wire;
      for (const std::size_t member : members) saved += all_[member].alone_bytes;
      groups.push_back({std::move(group), saved});
    }
    std::ranges::stable_sort(groups, std::greater(), &Candidate::saved);
    for (std::size_t i = 0; i < groups.size(); ++i) {
      if (i < limits_.groups_max && groups[i].saved > 0)
        shares.push_back(std::move(groups[i].group));
      else
        serve_alone(groups[i].group.members);
    }
    return shares;
  }

  /// Makes one group with the union of all masks. The smallest shares stay separate, as long as groups and
  /// separate copies together have no more bytes on the wire than allowed. So a reader of a small field does
  /// not get a large field.
  std::vector<Share> unite(std::vector<Share> apart) const {
    std::ranges::stable_sort(apart, {}, [](const Share& share) { return share.cost.wire; });
    std::vector<FieldMask> from(apart.size());  // [i]: the fields of share i and of all following shares
    for (std::size_t i = apart.size(); i-- > 0;)
      from[i] = i + 1 == apart.size() ? apart[i].fields.mask() : apart[i].fields.mask() | from[i + 1];
    std::vector<Share> shares;
    std::vector<std::size_t> united;
    std::size_t shares_united = 0, groups = 1;
    FieldMask fields;
    // Only half of the allowed surplus may be used, because acks and repairs of the separate destinations
    // are not counted.
    const double outside_max = (1 + limits_.wire_max) / 2 * everyone_.cost.wire;
    double outside = 0;
    for (std::size_t i = 0; i < apart.size(); ++i) {
      const Share& share = apart[i];
      const std::size_t behind = apart.size() - i - 1;
      bool stays_out = shares_united + behind > 1 && (!share.is_group() || groups < limits_.groups_max);
      if (stays_out) {
        const FieldMask rest = shares_united == 0 ? from[i + 1] : behind == 0 ? fields : fields | from[i + 1];
        stays_out = outside + share.cost.wire + wire_of_all(rest) <= outside_max;
      }
      if (stays_out) {
        outside += share.cost.wire;
        groups += share.is_group() ? 1 : 0;
        shares.push_back(share);
      } else {
        fields = shares_united++ == 0 ? share.fields.mask() : fields | share.fields.mask();
        united.insert(united.end(), share.members.begin(), share.members.end());
      }
    }
    shares.push_back(together(std::move(united)));
    return shares;
  }

  /// Returns the size on the wire of one copy with these fields, in bytes. Its datagrams have a length that
  /// the paths to all members carry.
  double wire_of_all(const FieldMask& fields) const {
    std::size_t datagram_bytes = SIZE_MAX;
    for (const Share& one : alone_)
      datagram_bytes = std::min(datagram_bytes, all_[one.members.front()].datagram_bytes);
    return wire_bytes(body_bytes_(fields), datagram_bytes, PlaceMark::in_group);
  }

  const std::span<const PlanDestination> all_;
  const BodyBytes& body_bytes_;
  const PlanLimits& limits_;
  const std::vector<std::vector<std::size_t>> equals_;
  std::vector<Share> alone_;
  Share everyone_;
  double wire_max_ = 0;
  std::vector<Share> shares_;
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
    one.take_over(present);
    if (passing_per_s) one.dissolve_if_rare(here_per_s);
    one.improve(here_per_s);
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
