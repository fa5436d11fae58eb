// Another process: which of its records hold. A process has a participant on each of its links, and writes
// all its records by each of them. Each participant has a table of its own, so that what a broken or forged
// link has brought can be distinguished from what other links bring.
//
// Of the participants of a process these count:
//
// 1. those whose tables agreed with the process's heartbeats at least once, and are not suspect;
// 2. if there are none, those that agreed at least once;
// 3. if there are none, the one that was found first.
//
// So a participant that claims the id of another process counts for nothing beside that process's own
// participants. Of the records with one key in the tables of the participants that count, the one with the
// greatest revision holds, whichever link has brought it. All tables are compared with the digests of the
// first participant that sends heartbeats regularly.
//
// This is all that the core does about trust. Without DDS Security, a record or heartbeat that is forged in
// the name of a process cannot be distinguished from a true one. It is corrected like a record that was lost:
// the digests of the process itself disagree with the table, and the link is made anew. With DDS Security
// Cyclone drops what comes without a certificate (SECURITY.md).
//
// Pure: events and times go in, changes come out. One thread at a time.
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

/// What one participant of another process has written, as one of our links has brought it.
struct Participant {
  std::optional<ProcessId> process{};  ///< nothing while only records have come
  Time found_at{};
  std::optional<Time> heard_at{};  ///< the last heartbeat
  IpAddress address{};             ///< where that came from; any: by Cyclone
  Time regular_since{};            ///< no two heartbeats in a row were missing since then
  PerRole<RemoteTable> tables{};
  bool has_agreed = false;       ///< its tables have matched the process's digests at least once
  bool is_suspect = false;       ///< a record is missing in its tables, or is not the process's own
  bool is_silent = false;        ///< no heartbeat came for the lease
  bool is_cropped = false;       ///< a record found no room, so digests prove nothing
  bool is_own = false;           ///< belongs to this process, or claims to
  bool is_one_too_many = false;  ///< its process has the greatest number already

  bool is_late(const Timing& timing, Time now) const {
    return now - heard_at.value_or(found_at) >= timing.late;
  }
};

class Peer {
 public:
  /// For each role, the time since which its records are read; empty if they are not.
  using Listened = PerRole<std::optional<Time>>;
  /// Called with the record that holds now. It has no body if none holds any more, or if it was withdrawn.
  using Changed = std::function<void(Role, const RecordKey&, const Record&)>;

  /// `timing` and `listened` outlive this object.
  Peer(const Timing& timing, const Listened& listened, Changed changed)
      : timing_(timing), listened_(listened), changed_(std::move(changed)) {}

  // Events.

  /// A participant was found, or is not silent any more. It must exist until leave() is called or this object
  /// is destroyed.
  void join(const RemoteParticipant& id, Participant& participant);
  void leave(const RemoteParticipant& id);
  /// Link `by` was made in place of the link. If the process was found by the old link, it should be heard by
  /// the new one.
  void link_replaced(LinkId link, LinkId by);
  void link_gone(LinkId link) { links_.erase(link); }
  /// The participant has sent the digests of the process's records.
  void heartbeat_came(const RemoteParticipant& by, const PerRole<std::uint64_t>& digests, Time now);
  void record_came(Participant& of, Role role, const RecordKey& key);
  /// The tables of the participant lack a record of the process, or have one that is not the process's own.
  void suspect(Participant& participant);

  // Answers.

  std::size_t participants() const { return members_.size(); }
  /// Returns the records of that role that hold, also withdrawn ones.
  const Records& records(Role role) const { return records_[role]; }
  /// Returns true if all records that the last heartbeat counts have come by that link.
  bool is_complete_on(LinkId link) const;
  /// Returns true if they have come by any other link.
  bool is_complete_beside(LinkId link) const;
  /// Links by which the process was found and is not heard any more, and those by which it is heard. Both are
  /// empty if there are none of either kind. A link that was cut stays so until the process is heard by it
  /// again, however long that takes.
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
  std::vector<Member> members_;                      ///< the one that was found first is the first
  std::set<LinkId> links_;                           ///< by which the process has been found
  std::optional<PerRole<std::uint64_t>> digests_{};  ///< of the last heartbeat that counts
  PerRole<Records> records_{};
};

}  // namespace sft::core
