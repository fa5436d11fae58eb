// Decides when a link is made anew, when a replaced link is closed, and when the participant of a link
// announces itself again. Pure: events and times are passed in, decisions are returned. An object must be
// used by only one thread at a time.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <vector>

#include "core/discovery/records.h"
#include "core/discovery/timing.h"
#include "core/platform/clock.h"

namespace sft::core {

class LinkCare {
 public:
  /// `self` varies the waiting times, so that processes that notice the same loss do not all act at the same
  /// time.
  LinkCare(ProcessId self, const Timing& timing) : self_(self), timing_(timing) {}

  // Events that change the state.

  /// `heartbeats_find`: heartbeats of participants that Cyclone does not know arrive on the link. Where they
  /// do not, Cyclone would repeat an announcement that was lost only after minutes. So a new link repeats it
  /// soon, and then with pauses that double, until two leases are over.
  void made(LinkId link, Time now, bool heartbeats_find = true);
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
  /// A known participant has asked all others to announce themselves, or gives no heartbeats, because it
  /// probably does not know this process.
  void was_asked(LinkId link);
  /// Cables, switches or interfaces have changed.
  void network_changed(Time now);
  /// Sets the links on which records of some participants are missing, even if other links have brought these
  /// records. The value is true if the link has brought all records of one of these participants before. Then
  /// a renewal will probably help. If a participant was made up, renewals never help.
  void misses(const std::map<LinkId, bool>& links);

  // Questions about the state.

  bool has(LinkId link) const { return links_.contains(link); }
  bool is_retired(LinkId link) const { return links_.at(link).retired_at.has_value(); }
  /// Returns the time from which a record counts as lost on the link, if the table has lacked it since
  /// `behind_since`. Newcomers on the link postpone this time, but by no more than a lease. Otherwise a
  /// process that crashes again and again, and is a newcomer each time, would postpone it for ever.
  Time missed_from(LinkId link, Time behind_since, bool was_complete) const;

  struct Announcement {
    LinkId link = 0;
    bool asks = false;  ///< asks all receivers to announce themselves, too
  };
  struct Due {
    std::vector<LinkId> renewals{};  ///< the links that have to be replaced by new ones
    std::vector<LinkId> ends{};      ///< the retired links that have to be closed
    std::vector<Announcement> announcements{};
  };
  /// Returns what is due now. A link is renewed at most once in a lease. The pause doubles while renewals do
  /// not help, and also while they fail.
  Due look(Time now);
  /// Returns the time by which look() must be called again; Time::max() if no call is needed.
  Time next() const;

 private:
  struct Link {
    Time stirred_at{};  ///< when a participant, or a record of a participant with an incomplete table, last
                        ///< came
    std::size_t participants = 0;
    std::optional<bool> misses{};  ///< the value of the last call of misses(); empty: nothing is missing
    Time renewed_at{};             ///< when the link was made, or could not be renewed
    std::chrono::milliseconds
        pause{};  ///< the least time between that and the next renewal, beside the lease
    std::optional<Time> retired_at{};
    std::optional<Time>
        unknown_at{};  ///< when the first heartbeat of an unknown participant came after the last question
    bool has_unknown = false, was_asked = false;
    Time repeat_until{};                         ///< the end of the time in which announcements are repeated
    Time announce_at{};                          ///< the earliest time of the next announcement on the link
    std::chrono::milliseconds announce_pause{};  ///< the pause after the last announcement
  };
  /// The maximum number of participants of a link for which waiting times are extended. Further
  /// participants do not extend them, since an attacker may make them up.
  static constexpr std::size_t participants_counted_max = 100;

  Time renewal_due(const Link& link) const;
  std::optional<Announcement> announcement(LinkId id, Link& link, Time now) const;

  const ProcessId self_;
  const Timing timing_;
  std::map<LinkId, Link> links_;
};

}  // namespace sft::core
