// All times of the control plane, each with its reason. All other waiting times of the control plane are
// multiples or fractions of these. There are 13 of them. A new one should replace one of these.
#pragma once

#include <chrono>

namespace sft::core {

/// discovery.md says how these times follow from what a user notices.
struct Timing {
  using Milliseconds = std::chrono::milliseconds;

  /// Each participant sends a heartbeat with this period, and six heartbeats come within a lease. A network
  /// that loses a fifth of all datagrams loses six in a row in one of 16,000 cases.
  Milliseconds heartbeat_every{1'000};
  /// A change is followed by a heartbeat at once, but no sooner than this after the previous heartbeat. So
  /// masks that change at 1 kHz cost two heartbeats a second.
  Milliseconds heartbeat_pause{500};
  /// A participant without heartbeats for this time counts as ended. So a killed process is noticed within
  /// 7 s.
  Milliseconds lease{6'200};
  /// After this time, two heartbeats in a row are missing: the path by this link may be cut, so another
  /// link is preferred.
  Milliseconds late{2'500};

  /// A record may come this much later than a heartbeat that counts it, since it may have to be sent again.
  Milliseconds settle{1'000};
  /// Added to `settle` for each participant of the link, because many processes that start together delay
  /// each other.
  Milliseconds settle_each{30};
  /// The pause between two renewals of a link begins with `lease`, and doubles up to this value while
  /// renewals do not help. So a participant that an attacker makes up causes few renewals.
  Milliseconds renew_pause_max{60'000};

  /// Cyclone drops a participant from which no announcement comes for this time, and repeats our
  /// announcements after three quarters of it. The time may be long, because heartbeats show which
  /// processes live, and newcomers are asked to announce themselves.
  Milliseconds cyclone_lease{40'000};
  /// Replaces `cyclone_lease` where announcements go to all ports of each peer, because they cost most there.
  Milliseconds cyclone_lease_to_peers{160'000};

  /// The list of interfaces is also read with this period, because netlink drops messages when many come at
  /// once.
  Milliseconds look_at_interfaces{10'000};
  /// An operation that the system has refused (a link, a list of interfaces, a record) is tried again after
  /// this time.
  /// This is soon enough for people, and costs little even if it continues for hours.
  Milliseconds try_again{1'000};
  /// A process that ends waits at most this long until other processes have acknowledged its last records.
  /// Living participants acknowledge within milliseconds, and killed ones never do.
  Milliseconds farewell_max{1'000};
  /// Opening the first links waits at most this long for the addresses of peers that are given by name. A
  /// reachable name server answers within it. Peers whose addresses are found later are added by renewing
  /// the links.
  Milliseconds wait_for_names{200};
};

}  // namespace sft::core
