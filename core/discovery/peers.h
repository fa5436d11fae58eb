// Keeps track of the other processes and of their participants on each link: decides which processes live,
// which of their records are in force, what is missing, and what has to be done with the links of this
// process.
//
// A process has a participant on each of its links, and writes all its records by each of them. Each
// participant has tables of its own, so that records from a broken link can be distinguished from others.
// Only these participants of a process count:
//
// 1. those whose tables agreed with the process's heartbeats at least once, and are not suspect;
// 2. if there are none, those that agreed at least once;
// 3. if there are none, the one that was found first.
//
// So a participant with the forged id of a process does not count while that process's own
// participants do. If the tables of the participants that count have several records with the same key, the
// record with the greatest revision is in force, whichever link has brought it. All tables are compared
// with the digests of the first participant that sends heartbeats regularly.
//
// This is all that the core does about trust. Without DDS Security, a record or heartbeat that is forged in
// the name of a process cannot be distinguished from a true one. It is corrected like a record that was
// lost: the digests of the process itself disagree with the table, and the link is made anew. With DDS
// Security, Cyclone drops data without a certificate (SECURITY.md).
//
// Uses no clock, thread or I/O: events and times are passed in, actions are returned. An object must be used
// by only one thread at a time.
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
#include "core/discovery/records.h"
#include "core/discovery/remote_table.h"
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
/// Heartbeats of the process come by the links `heard`, but no longer by the links `links`: the path there is
/// interrupted. Both lists are empty once no path is interrupted any more. A link counts as cut until a
/// heartbeat comes by it again, however long that takes.
struct PathsCut {
  ProcessId process = 0;
  std::vector<LinkId> links{};
  std::vector<LinkId> heard{};  ///< the links with heartbeats; two of these may lead to the same network
  friend bool operator==(const PathsCut&, const PathsCut&) = default;
};
/// Something that has to be done with a link of this process.
struct LinkAction {
  enum class Kind : std::uint8_t {
    renew,     ///< records are missing on the link, which has to be replaced by a new one
    end,       ///< the retired link is not needed any more, and has to be closed
    announce,  ///< the participant on the link has to announce itself once more
    ask,       ///< the same, and it has to ask all receivers to announce themselves, too
    use_topic  ///< heartbeats of a participant that Cyclone has found do not arrive, because a firewall may
               ///< let only the ports of DDS pass; so heartbeats have to be sent through Cyclone
  };
  LinkId link = 0;
  Kind kind{};
  IpAddress from{};  ///< for `renew`: the address of a process whose records are missing; "any" if it is not
                     ///< known
};
using PeerAction = std::variant<PeerLost, RecordChanged, PathsCut, LinkAction>;

/// These limits bound what attackers can make this process store. Further records are refused, counted and
/// logged.
struct PeerLimits {
  std::size_t records = 4'096;                        ///< of one participant
  std::size_t bytes = std::size_t{16} << 20;          ///< the bytes of these records
  std::size_t bytes_of_all = std::size_t{256} << 20;  ///< the bytes of the records of all participants
};

/// A participant of another process on one of our links, and the records that it has written.
struct Participant {
  std::optional<ProcessId> process{};  ///< nothing if only records of the participant have come so far
  Time found_at{};
  std::optional<Time> heard_at{};  ///< when the last heartbeat came
  IpAddress address{};             ///< the address that the last heartbeat came from; "any" if it came
                                   ///< through Cyclone
  Time regular_since{};            ///< the time since which no two successive heartbeats were missing
  PerRole<RemoteTable> tables{};
  bool has_agreed = false;  ///< its tables have matched the process's digests at least once
  bool is_suspect = false;  ///< a record is missing in its tables, or is not the process's own
  bool is_silent = false;   ///< no heartbeat came for the lease
  bool is_cropped = false;  ///< some records did not fit into the free memory, so digests prove nothing
};
using Participants = std::map<RemoteParticipant, Participant>;

/// Another process that lives.
struct Peer {
  ProcessId process = 0;
  std::vector<Participants::value_type*> participants{};  ///< in the order in which they were found
  std::set<LinkId> links{};                               ///< the links by which the process has been found
  /// The digests of the last heartbeat that counts for the whole process; empty: there was none.
  std::optional<PerRole<std::uint64_t>> digests{};
  PerRole<Records> records{};  ///< the records that are in force, including withdrawn ones
  PathsCut cut{};              ///< as last reported
};

/// Larger than usual: there is a function for each kind of event.
class Peers {
 public:
  /// `self` also varies the waiting times, so that processes that notice the same loss do not all act at the
  /// same time.
  Peers(ProcessId self, const Timing& timing, const PeerLimits& limits = {})
      : self_(self), timing_(timing), limits_(limits) {}
  Peers(const Peers&) = delete;
  Peers& operator=(const Peers&) = delete;

  // Events that change the state.

  /// Records of that role are read from now on.
  void listen(Role role, Time now);
  /// Must be called before the link is opened. `heartbeats_find`: heartbeats of participants that Cyclone
  /// does not know arrive on the link. Where they do not, Cyclone would repeat an announcement that was lost
  /// only after minutes. So a new link repeats it soon, and then with pauses that double, until two leases
  /// are over.
  void link_made(LinkId link, Time now, bool heartbeats_find = true);
  /// The link is retired, because link `by` was made to replace it. If processes were found by the old link,
  /// their heartbeats are expected on the new link.
  void link_replaced(LinkId link, LinkId by, Time now);
  /// The link is retired, because its address is gone.
  void link_retired(LinkId link, Time now);
  void link_gone(LinkId link);
  /// Cables, switches or interfaces have changed.
  void network_changed(Time now);
  /// Cyclone has found a participant whose user data name this process, or its user data have changed.
  /// If later user data of this participant name another process, they are ignored. `asks`: the participant
  /// asks all others to announce themselves. This is ignored if the participant is new, since its user data
  /// may be old then.
  void participant_found(const RemoteParticipant& id, ProcessId process, Time now, bool asks = false);
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

 private:
  /// The state from which decisions about a link of this process follow.
  struct Link {
    Time stirred_at{};             ///< when a participant, or a record of a participant whose tables never
                                   ///< agreed, last came
    std::size_t participants = 0;  ///< the number of participants that were found on the link
    std::optional<Time> retired_at{};
    /// Empty if nothing is missing. True if the link has brought all records of a participant of which it
    /// misses some now. Then a renewal will probably help. If a participant was made up, it never helps.
    std::optional<bool> misses{};
    IpAddress misses_from{};            ///< see LinkAction
    Time renewed_at{};                  ///< when the link was made, or could not be renewed
    std::chrono::milliseconds pause{};  ///< the time from that until a renewal that may not help
    bool has_unknown = false;  ///< a participant that Cyclone does not know gives heartbeats, or the network
                               ///< has changed
    bool was_asked = false;    ///< a known participant has asked all others to announce themselves, or gives
                               ///< no heartbeats, because it probably does not know this process
    Time repeat_until{};       ///< the end of the time in which announcements are repeated
    std::optional<Time> unknown_at{};            ///< when the first heartbeat of an unknown participant came
                                                 ///< after the last question
    bool is_unheard = false;                     ///< LinkAction::Kind::use_topic was reported
    Time announce_at{};                          ///< the earliest time of the next announcement
    std::chrono::milliseconds announce_pause{};  ///< the pause after the last announcement
  };
  /// The maximum number of participants of a link for which waiting times are extended. Further
  /// participants do not extend them, since an attacker may make them up.
  static constexpr std::size_t participants_counted_max = 100;

  bool has_room(const Participant& of, Role role, const RecordKey& key, const Record& record) const;
  void forget_tables(Participant& participant);
  void join(Participants::value_type& member);
  void leave(const RemoteParticipant& id, ProcessId process);
  void unknown_came(Link& link, Time now) const;
  void compare(Peer& peer, Time now);
  bool is_complete(const Peer& peer, const Participant& participant) const;
  void refresh(Peer& peer, const std::vector<const Participant*>& counting, Role role, const RecordKey& key);
  void refresh_all(Peer& peer);
  Time missed_at(LinkId link, const Participant& participant) const;
  Time unheard_at(LinkId link, const Participant& participant) const;
  Time renewal_due(const Link& link) const;
  static Time announcement_due(const Link& link);
  void look_at(const RemoteParticipant& id, Participant& participant, Time now);
  void look_at_room(Time now);
  void look_at_link(LinkId id, Link& link, Time now);

  const ProcessId self_;
  const Timing timing_;
  const PeerLimits limits_;
  PerRole<std::optional<Time>> listened_{};  ///< for each role, the time since which its records are read
  std::map<LinkId, Link> links_;
  Participants participants_;
  std::map<ProcessId, Peer> peers_;
  std::size_t bytes_ = 0;  ///< the bytes of the records of all participants
  Time looked_at_{};
  std::vector<PeerAction> actions_;
};

}  // namespace sft::core
