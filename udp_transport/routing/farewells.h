// Sends farewells to the members of multicast groups that have ended. A farewell tells a member that it is
// not in the group any more (multicast.md). Farewells are not urgent, and those to all members of a large
// group would together have as many bytes as some samples. So each call sends only a few. Uses no clock,
// thread or I/O.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <map>
#include <memory>

#include "udp_transport/multicast/multicast_group.h"

namespace sft::udp {

class Farewells {
 public:
  using Time = MulticastGroup::Time;

  /// The delay of a farewell, so that samples that are under way arrive first.
  static constexpr std::chrono::seconds farewell_after{1};
  /// The maximum number of farewells per call is `notified_at_once`, or the number of due farewells divided
  /// by `part_notified_at_once` if that is more.
  static constexpr std::size_t notified_at_once = 8, part_notified_at_once = 8;

  /// Notes that the group has ended. A farewell also ends the member's membership of all earlier groups, so
  /// each destination is in the list only once.
  void note(const std::shared_ptr<MulticastGroup>& group, Time now) {
    for (std::size_t i = 0; i < group->members().size(); ++i) {
      const Destination* to = &group->members()[i].lane->destination();
      farewells_.insert_or_assign(to, Farewell{group, i, now + farewell_after});
    }
  }

  /// Calls `send(destination, farewell)` for some of the farewells that are due.
  template <class Send>
  void say(Time now, const Send& send) {
    const auto is_due = [now](const auto& item) { return now >= item.second.due; };
    const auto due = static_cast<std::size_t>(std::ranges::count_if(farewells_, is_due));
    std::size_t left = std::max(notified_at_once, due / part_notified_at_once);
    std::erase_if(farewells_, [&](const auto& item) {
      if (left == 0 || !is_due(item)) return false;
      const Farewell& farewell = item.second;
      send(farewell.group->members()[farewell.member].lane->destination(),
           farewell.group->farewell(farewell.member));
      --left;
      return true;
    });
  }

 private:
  /// A farewell to a destination as a member of its latest group that has ended.
  struct Farewell {
    std::shared_ptr<MulticastGroup> group;
    std::size_t member = 0;
    Time due{};
  };
  std::map<const Destination*, Farewell> farewells_;
};

}  // namespace sft::udp
