// All times of the control plane, each with its reason. All other waiting times there are multiples or parts
// of these. There are 15 of them: a new one should replace another one.
#pragma once

#include <chrono>

namespace sft::core {

/// discovery.md says how these times follow from what a user notices.
struct Timing {
  using Milliseconds = std::chrono::milliseconds;

  /// Each participant sends a heartbeat this often, and reads those of others: six come within a lease. A
  /// network that loses a fifth of all datagrams loses six in a row in one of 16,000 cases.
  Milliseconds heartbeat_every{1'000};
  /// A change is followed by a heartbeat at once, but not sooner than this after the heartbeat before: masks
  /// that change at 1 kHz cost two heartbeats a second.
  Milliseconds heartbeat_pause{500};
  /// A participant without heartbeats for this time has ended: a killed process is noticed within 7 s.
  Milliseconds lease{6'200};
  /// After this time, two heartbeats in a row are missing: the path by this link may be cut, so another one
  /// is preferred.
  Milliseconds late{2'500};

  /// A record may come this much later than a heartbeat that counts it: it may have to be sent again.
  Milliseconds settle{1'000};
  /// Added to `settle` for each participant of the link, because many processes that start together delay
  /// each other.
  Milliseconds settle_each{30};
  /// The pause between two renewals of a link begins with `lease`, and doubles up to this while they do not
  /// help. So a participant that an attacker makes up causes few renewals.
  Milliseconds renew_pause_max{60'000};
  /// A replaced link stays this long at least: participants on the new one answer within one heartbeat.
  Milliseconds retire_after{1'000};

  /// Cyclone drops a participant from which nothing comes for this time, and repeats its own announcements
  /// after three quarters of it. The time may be long, because heartbeats show which processes live, and
  /// newcomers are asked to announce themselves.
  Milliseconds cyclone_lease{40'000};
  /// Replaces `cyclone_lease` where announcements go to all ports of each peer, because they cost most there.
  Milliseconds cyclone_lease_to_peers{160'000};

  /// Interfaces are also read this often, because netlink drops messages when many come at once.
  Milliseconds look_at_interfaces{10'000};
  /// What the system refused is tried again after this time: a link, a list of interfaces, a record. That is
  /// soon for people, and costs little while it goes on for hours.
  Milliseconds try_again{1'000};
  /// A process that ends waits this long at most until the others have its last records. Participants that
  /// live confirm it within milliseconds, and those that were killed never do.
  Milliseconds farewell_max{1'000};
  /// The first links ask the peers by name that are looked up within this time, as a name server that can be
  /// reached answers within it. Other peers join later, by links that are made anew.
  Milliseconds wait_for_names{200};
  /// Participants of other releases are named in the log no more often, since they announce themselves again
  /// and again.
  Milliseconds name_releases_every{60'000};
};

}  // namespace sft::core
