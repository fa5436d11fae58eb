// Keeps track of the other processes and of their participants on each link: decides which processes are
// alive, when records of them are missing, and what has to be done with the links of this process. Uses no
// clock, thread or I/O: events and times are passed in, actions are returned. An object must be used by
// only one thread at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <variant>
#include <vector>

#include "core/discovery/heartbeat.h"
#include "core/discovery/link_care.h"
#include "core/discovery/peer.h"
#include "core/discovery/records.h"
#include "core/discovery/timing.h"
#include "core/platform/clock.h"
#include "core/platform/ip_address.h"

namespace sft::core {

/// All participants of the process are silent or gone, and none of its records is in force.
struct PeerLost {
  ProcessId process = 0;
};
/// Another record with this key is in force now. The record has no body if it was withdrawn, or if it was
/// not the process's own.
struct RecordChanged {
  ProcessId process = 0;
  Role role{};
  RecordKey key{};
  Record record{};
};
/// Heartbeats of the process come by the links `heard`, but no longer by the links `cut`: the path there is
/// interrupted. Both lists are empty once no path is interrupted any more.
struct PathsCut {
  ProcessId process = 0;
  std::vector<LinkId> links{};
  std::vector<LinkId> heard{};  ///< the links with heartbeats; two of these may lead to the same network
};
/// Heartbeats of a participant that Cyclone has found do not arrive on the link. A firewall may let only
/// the ports of DDS pass. So heartbeats have to be sent through Cyclone.
struct HeartbeatsMissing {
  LinkId link = 0;
};
/// The retired link is not needed any more and has to be closed.
struct EndLink {
  LinkId link = 0;
};
/// Records are missing on the link, which has to be replaced by a new one.
struct RenewLink {
  LinkId link = 0;
  IpAddress from{};  ///< the address of a process whose records are missing; "any" if it is not known
};
using Announce = LinkCare::Announcement;
using PeerAction =
    std::variant<PeerLost, RecordChanged, PathsCut, HeartbeatsMissing, RenewLink, Announce, EndLink>;

/// These limits bound what attackers can make this process store. Further records are refused, counted and
/// logged.
struct PeerLimits {
  std::size_t records = 4'096;                        ///< of one participant
  std::size_t bytes = std::size_t{16} << 20;          ///< the bytes of these records
  std::size_t bytes_of_all = std::size_t{256} << 20;  ///< the bytes of the records of all participants
  /// The maximum number of participants of one process: one on each link, and a second one on a link that
  /// is being replaced.
  std::size_t participants = 32;
};

class Peers {
 public:
  Peers(ProcessId self, const Timing& timing, const PeerLimits& limits = {})
      : self_(self), timing_(timing), limits_(limits), care_(self, timing) {}
  Peers(const Peers&) = delete;
  Peers& operator=(const Peers&) = delete;

  // Events that change the state.

  /// Records of that role are read from now on.
  void listen(Role role, Time now);
  /// Must be called before the link is opened.
  void link_made(LinkId link, Time now, bool heartbeats_find = true) {
    care_.made(link, now, heartbeats_find);
  }
  void link_replaced(LinkId link, LinkId by, Time now);
  void link_retired(LinkId link, Time now) { care_.retire(link, now); }
  void link_gone(LinkId link);
  /// Cables, switches or interfaces have changed.
  void network_changed(Time now) { care_.network_changed(now); }
  /// Cyclone has found a participant that claims to belong to the process. Later claims of this participant
  /// to another process are ignored.
  void participant_found(const RemoteParticipant& id, ProcessId process, Time now);
  /// A participant that was found before asks all others to announce themselves.
  void participant_asks(const RemoteParticipant& id);
  void participant_gone(const RemoteParticipant& id);
  /// A record may come before its participant is found. Returns false if the limits leave no memory for it.
  bool record_came(const RemoteParticipant& by, Role role, const RecordKey& key, Record record, Time now);
  /// `age`: the time for which the heartbeat has waited to be read. `from`: the address that the heartbeat
  /// came from; "any" if it is not known.
  void heartbeat_came(LinkId link, const Heartbeat& heartbeat, Time now, Time::duration age = {},
                      const IpAddress& from = {});
  /// Must be called after heartbeat_came() for all heartbeats that were read.
  void look(Time now);

  // Questions about the state.

  std::vector<PeerAction> take_actions() { return std::exchange(actions_, {}); }
  /// Returns the time by which look() must be called; Time::max() if no call is needed.
  Time next() const;
  /// Returns the process; null if it is not there.
  const Peer* find(ProcessId process) const;
  /// Returns the process of the participant; nothing if the participant is ignored or silent.
  std::optional<ProcessId> process_of(const RemoteParticipant& id) const;
  /// Returns when a participant was last found; Time{} if none was. Records of that participant may still
  /// be on their way.
  Time newcomer_at() const { return newcomer_at_; }

 private:
  using Participants = std::map<RemoteParticipant, Participant>;

  bool has_room(const Participant& of, Role role, const RecordKey& key, const Record& record) const;
  void admit(const RemoteParticipant& id, Participant& participant, Time now);
  void join(const RemoteParticipant& id, Participant& participant);
  void leave(const RemoteParticipant& id, const Participant& participant);
  Time missed_at(LinkId link, const Participant& participant) const;
  Time unheard_at(LinkId link, const Participant& participant) const;
  void look_at(const RemoteParticipant& id, Participant& participant, Time now);
  void look_at_room(Time now);
  void forget_tables(Participant& participant);
  void look_at_paths(Time now);
  void look_at_links(Time now);

  const ProcessId self_;
  const Timing timing_;
  const PeerLimits limits_;
  LinkCare care_;
  Peer::Listened listened_{};
  Participants participants_;
  std::map<ProcessId, Peer> peers_;
  std::map<ProcessId, Peer::Paths> cut_;  ///< the cut paths of each process as last reported by PathsCut
  std::set<LinkId> unheard_;              ///< links for which HeartbeatsMissing was reported
  std::size_t bytes_ = 0;                 ///< the bytes of the records of all participants
  Time newcomer_at_{};
  Time looked_at_{};
  std::vector<PeerAction> actions_;
};

}  // namespace sft::core
