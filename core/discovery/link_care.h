// Decides when a link is made anew, when a replaced link is closed, and when the participant of a link
// announces itself again. Pure: events and times go in, answers come out. One thread at a time.
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

  // Events.

  void made(LinkId link, Time now);
  /// The link retires, since link `by` was made in its place.
  void replaced(LinkId link, LinkId by, Time now);
  /// The link is not needed any more: its address is gone.
  void retire(LinkId link, Time now);
  void gone(LinkId link) { links_.erase(link); }
  /// A participant was found on the link.
  void joined(LinkId link, Time now);
  void left(LinkId link);
  /// A record came of a participant whose records have not all come yet.
  void stirred(LinkId link, Time now);
  /// A heartbeat came of a participant that Cyclone does not know. Either side may have lost the other.
  void unknown_came(LinkId link, Time now);
  /// A known participant asks all others to announce themselves.
  void was_asked(LinkId link);
  /// Cables, switches or interfaces have changed.
  void network_changed(Time now);
  /// On each link, records of these processes are missing. Other links may have brought them.
  void misses(const std::map<LinkId, std::set<ProcessId>>& processes);

  // Answers.

  bool has(LinkId link) const { return links_.contains(link); }
  bool is_retired(LinkId link) const { return links_.at(link).retired_at.has_value(); }
  /// Returns when a table that is behind since `behind_since` lacks a record for good. Newcomers on the link
  /// make this later, but by no more than a lease: a process that crashes again and again is a newcomer each
  /// time.
  Time missed_from(LinkId link, Time behind_since, bool was_complete) const;

  struct Renewal {
    LinkId link = 0;
    ProcessId because_of = 0;
    IpAddress from{};  ///< its address, as Peers knows it; any: it does not
  };
  struct Announcement {
    LinkId link = 0;
    bool asks = false;  ///< all receivers to announce themselves, too
  };
  struct Due {
    std::vector<Renewal> renewals{};  ///< these links have to be made anew, and replaced
    std::vector<LinkId> ends{};       ///< these have to be closed
    std::vector<Announcement> announcements{};
  };
  /// A renewal that fails is due again later, with pauses that double. `is_complete(process, link)`: all
  /// records of that process have come on the link, or the process is not there. `is_covered(link)`: all
  /// records of the processes that are heard on the link have come on other links, too.
  Due look(const std::function<bool(ProcessId, LinkId)>& is_complete,
           const std::function<bool(LinkId)>& is_covered, Time now);
  /// The time of the next look at the latest; Time::max() if none is needed.
  Time next() const;

 private:
  struct Link {
    Time made_at{};
    Time stirred_at{};  ///< when a participant, or a record of an incomplete one, last came
    std::size_t participants = 0;
    std::chrono::milliseconds pause{};  ///< after `made_at`, until the link may be made anew
    std::set<ProcessId> misses{};
    std::set<ProcessId> made_for{};  ///< the link was made anew for these, and they are not complete yet
    Time renew_at{};                 ///< not before this, if making it anew has failed
    std::chrono::milliseconds retry_pause{};  ///< after the last attempt to make it anew
    std::optional<Time> retired_at{};
    Time look_again_at{};  ///< when to check whether the retired link may end
    std::optional<Time>
        unknown_at{};  ///< when an unknown participant was heard first since the last question
    bool has_unknown = false, was_asked = false;
    Time announce_at{};                          ///< the link announces itself no earlier than this
    std::chrono::milliseconds announce_pause{};  ///< after the last announcement
  };
  /// More participants of a link do not prolong any wait, since an attacker may make them up.
  static constexpr std::size_t participants_counted_max = 100;

  static Time renewal_due(const Link& link) { return std::max(link.made_at + link.pause, link.renew_at); }
  bool may_end(LinkId id, Link& link, const std::function<bool(LinkId)>& is_covered, Time now) const;
  std::optional<Announcement> announcement(LinkId id, Link& link, Time now) const;

  const ProcessId self_;
  const Timing timing_;
  std::map<LinkId, Link> links_;
};

}  // namespace sft::core
