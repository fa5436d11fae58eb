// Decides when a link is made anew, when a replaced link is closed, and when the participant of a link
// announces itself again. Pure: events and times are passed in, decisions are returned. An object must be
// used by only one thread at a time.
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "core/discovery/records.h"
#include "core/discovery/timing.h"
#include "core/platform/clock.h"
#include "core/platform/ip_address.h"

namespace sft::core {

class LinkCare {
 public:
  /// `self` varies the waiting times, so that processes that notice the same loss do not all act at the same
  /// time.
  LinkCare(ProcessId self, const Timing& timing) : self_(self), timing_(timing) {}

  // Events that change the state.

  void made(LinkId link, Time now);
  /// The link is retired, because link `by` was made to replace it.
  void replaced(LinkId link, LinkId by, Time now);
  /// The link is retired, because its address is gone.
  void retire(LinkId link, Time now);
  void gone(LinkId link) { links_.erase(link); }
  /// A participant was found on the link.
  void joined(LinkId link, Time now);
  void left(LinkId link);
  /// A record came from a participant whose table is not complete yet.
  void stirred(LinkId link, Time now);
  /// A heartbeat came of a participant that Cyclone does not know. Either this process or that participant
  /// may have lost the other.
  void unknown_came(LinkId link, Time now);
  /// A known participant has asked all others to announce themselves.
  void was_asked(LinkId link);
  /// Cables, switches or interfaces have changed.
  void network_changed(Time now);
  /// Sets, for each link, the processes with records that did not come by that link, even if other links have
  /// brought these records.
  void misses(const std::map<LinkId, std::set<ProcessId>>& processes);

  // Questions about the state.

  bool has(LinkId link) const { return links_.contains(link); }
  bool is_retired(LinkId link) const { return links_.at(link).retired_at.has_value(); }
  /// Returns the time from which a record counts as lost on the link, if the table has lacked it since
  /// `behind_since`. Newcomers on the link postpone this time, but by no more than a lease. Otherwise a
  /// process that crashes again and again, and is a newcomer each time, would postpone it for ever.
  Time missed_from(LinkId link, Time behind_since, bool was_complete) const;

  struct Renewal {
    LinkId link = 0;
    ProcessId because_of = 0;
    IpAddress from{};  ///< the address of that process, if Peers knows it; otherwise the address "any"
  };
  struct Announcement {
    LinkId link = 0;
    bool asks = false;  ///< asks all receivers to announce themselves, too
  };
  struct Due {
    std::vector<Renewal> renewals{};  ///< the links that have to be replaced by new ones
    std::vector<LinkId> ends{};       ///< the retired links that have to be closed
    std::vector<Announcement> announcements{};
  };
  /// Returns what is due now. A renewal that has failed is due again after a pause, which doubles each
  /// time. `is_complete(process, link)`: true if all records of that process have come on the link, or if
  /// the process is gone. `is_covered(link)`: true if all records of the processes whose heartbeats come on
  /// the link have come on other links, too.
  Due look(const std::function<bool(ProcessId, LinkId)>& is_complete,
           const std::function<bool(LinkId)>& is_covered, Time now);
  /// Returns the time by which look() must be called again; Time::max() if no call is needed.
  Time next() const;

 private:
  struct Link {
    Time made_at{};
    Time stirred_at{};  ///< when a participant, or a record of a participant with an incomplete table, last
                        ///< came
    std::size_t participants = 0;
    std::chrono::milliseconds pause{};  ///< the pause after `made_at` until the link may be made anew
    std::set<ProcessId> misses{};
    std::set<ProcessId> made_for{};  ///< the processes for which the link was made anew, and whose records
                                     ///< have not all come yet
    Time renew_at{};                 ///< the earliest time of the next attempt, if the last attempt to make
                                     ///< the link anew has failed
    std::chrono::milliseconds retry_pause{};  ///< the pause after the last attempt to make the link anew
    std::optional<Time> retired_at{};
    Time look_again_at{};  ///< when to check again whether the retired link may be closed
    std::optional<Time>
        unknown_at{};  ///< when the first heartbeat of an unknown participant came after the last question
    bool has_unknown = false, was_asked = false;
    Time announce_at{};                          ///< the earliest time of the next announcement on the link
    std::chrono::milliseconds announce_pause{};  ///< the pause after the last announcement
  };
  /// The maximum number of participants of a link for which waiting times are extended. Further
  /// participants do not extend them, since an attacker may make them up.
  static constexpr std::size_t participants_counted_max = 100;

  static Time renewal_due(const Link& link) { return std::max(link.made_at + link.pause, link.renew_at); }
  bool may_end(LinkId id, Link& link, const std::function<bool(LinkId)>& is_covered, Time now) const;
  std::optional<Announcement> announcement(LinkId id, Link& link, Time now) const;

  const ProcessId self_;
  const Timing timing_;
  std::map<LinkId, Link> links_;
};

}  // namespace sft::core
