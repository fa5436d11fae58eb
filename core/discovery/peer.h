// Another process, and which of its records are in force. A process has a participant on each of its links,
// and writes all its records by each of them. Each participant has a separate table, so that records from a
// broken or forged link can be distinguished from records from other links.
//
// Only these participants of a process count:
//
// 1. those whose tables agreed with the process's heartbeats at least once, and are not suspect;
// 2. if there are none, those that agreed at least once;
// 3. if there are none, the one that was found first.
//
// So a participant that falsely claims the id of a process does not count while that process's own
// participants do. If the tables of the participants that count have several records with the same key, the
// record with the greatest revision is in force, whichever link has brought it. All tables are compared
// with the digests of the first participant that sends heartbeats regularly.
//
// This is all that the core does about trust. Without DDS Security, a record or heartbeat that is forged in
// the name of a process cannot be distinguished from a true one. It is corrected like a record that was
// lost: the digests of the process itself disagree with the table, and the link is made anew. With DDS
// Security, Cyclone drops data without a certificate (SECURITY.md).
//
// Pure: events and times are passed in, changes are reported. An object must be used by only one thread at
// a time.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <set>
#include <vector>

#include "core/discovery/records.h"
#include "core/discovery/remote_table.h"
#include "core/discovery/timing.h"
#include "core/platform/clock.h"
#include "core/platform/ip_address.h"

namespace sft::core {

/// A participant of another process on one of our links, and the records that it has written.
struct Participant {
  std::optional<ProcessId> process{};  ///< nothing if only records of the participant have come so far
  Time found_at{};
  std::optional<Time> heard_at{};  ///< when the last heartbeat came
  IpAddress address{};             ///< the address that the last heartbeat came from; "any" if it came
                                   ///< through Cyclone
  Time regular_since{};            ///< the time since which no two successive heartbeats were missing
  PerRole<RemoteTable> tables{};
  bool has_agreed = false;       ///< its tables have matched the process's digests at least once
  bool is_suspect = false;       ///< a record is missing in its tables, or is not the process's own
  bool is_silent = false;        ///< no heartbeat came for the lease
  bool is_cropped = false;       ///< some records did not fit into the free memory, so digests prove nothing
  bool is_own = false;           ///< the participant belongs to this process, or claims to
  bool is_one_too_many = false;  ///< its process already has the maximum number of participants

  bool is_late(const Timing& timing, Time now) const {
    return now - heard_at.value_or(found_at) >= timing.late;
  }
};

class Peer {
 public:
  /// For each role, the time since which records of that role are read; empty if they are not read.
  using Listened = PerRole<std::optional<Time>>;
  /// Called with the record that is in force now. It has no body if no record with this key is in force, or
  /// if the record was withdrawn.
  using Changed = std::function<void(Role, const RecordKey&, const Record&)>;

  /// `timing` and `listened` must outlive this object.
  Peer(const Timing& timing, const Listened& listened, Changed changed)
      : timing_(timing), listened_(listened), changed_(std::move(changed)) {}

  // Events that change the state.

  /// A participant was found, or is not silent any more. `participant` must exist until leave() is called
  /// or this object is destroyed.
  void join(const RemoteParticipant& id, Participant& participant);
  void leave(const RemoteParticipant& id);
  /// `link` was replaced by link `by`. If the process was found by the old link, its heartbeats are
  /// expected on the new link.
  void link_replaced(LinkId link, LinkId by);
  void link_gone(LinkId link) { links_.erase(link); }
  /// The participant has sent the digests of the process's records.
  void heartbeat_came(const RemoteParticipant& by, const PerRole<std::uint64_t>& digests, Time now);
  void record_came(Participant& of, Role role, const RecordKey& key);
  /// The tables of the participant lack a record of the process, or have one that is not the process's own.
  void suspect(Participant& participant);

  // Questions about the state.

  std::size_t participants() const { return members_.size(); }
  /// Returns the records of that role that are in force, including withdrawn ones.
  const Records& records(Role role) const { return records_[role]; }
  /// The links by which the process was found and from which no heartbeats come any more, and the links by
  /// which heartbeats come. Both are empty if either kind is missing. A cut link counts as cut until a
  /// heartbeat comes by it again, however long that takes.
  struct Paths {
    std::vector<LinkId> cut{}, heard{};
    friend bool operator==(const Paths&, const Paths&) = default;
  };
  Paths paths(Time now) const;

 private:
  struct Member {
    RemoteParticipant id{};
    Participant* participant = nullptr;
  };
  bool is_complete(const Participant& participant) const;
  static bool note_as_complete(Participant& participant);
  bool speaks_for_all(const RemoteParticipant& id, Time now) const;
  std::vector<const Participant*> counting() const;
  void refresh(const std::vector<const Participant*>& counting, Role role, const RecordKey& key);
  void refresh_all();

  const Timing& timing_;
  const Listened& listened_;
  const Changed changed_;
  std::vector<Member> members_;  ///< in the order in which they were found
  std::set<LinkId> links_;       ///< the links by which the process has been found
  /// The digests of the last heartbeat whose participant speaks for the whole process; empty: there was none.
  std::optional<PerRole<std::uint64_t>> digests_{};
  PerRole<Records> records_{};
};

}  // namespace sft::core
