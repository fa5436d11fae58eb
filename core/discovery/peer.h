// Another process: which of its records hold. A process has a participant on each of its links, and writes
// all its records by each of them. Each participant has a table of its own, so that what a broken or forged
// link has brought can be told from what other links bring.
//
// Of the participants of a process these count:
//
// 1. those whose tables agreed with the process's heartbeats at least once, and are not suspect;
// 2. if there are none, those that agreed at least once;
// 3. if there are none, the one that was found first.
//
// So a participant that claims the process id of another one counts for nothing beside that. Of the records
// of those that count, the one with the greatest revision holds, whichever link has brought it. All tables
// are compared with the digests that the first participant gives which gives heartbeats regularly.
//
// This is all that the core does about trust. Without DDS Security a record or heartbeat that is forged in
// the name of a process is not told from a true one. It is corrected like a record that was lost: the digests
// of the process itself disagree with the table, and the link is made anew. With DDS Security Cyclone drops
// what comes without a certificate (SECURITY.md).
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
  bool has_agreed = false;       ///< its tables were at least once what the process says that they are
  bool is_suspect = false;       ///< something is missing in them, or is not the process's own
  bool is_silent = false;        ///< no heartbeat came for the lease
  bool is_cropped = false;       ///< a record found no room, so that digests tell nothing
  bool is_own = false;           ///< our own process has it, or it says so
  bool is_one_too_many = false;  ///< its process has as many as one may have

  bool is_late(const Timing& timing, Time now) const {
    return now - heard_at.value_or(found_at) >= timing.late;
  }
};

class Peer {
 public:
  /// The roles whose records are listened to, and since when.
  using Listened = PerRole<std::optional<Time>>;
  /// Is told which record holds now. It has no body if none holds any more, or if it was withdrawn.
  using Changed = std::function<void(Role, const RecordKey&, const Record&)>;

  /// All that it is given outlives this object.
  Peer(const Timing& timing, const Listened& listened, Changed changed)
      : timing_(timing), listened_(listened), changed_(std::move(changed)) {}

  // Events.

  /// A participant is there, or is not silent any more. It outlives this object, or leave().
  void join(const RemoteParticipant& id, Participant& participant);
  void leave(const RemoteParticipant& id);
  /// The link is made anew: where it led to the process, its successor should.
  void link_replaced(LinkId link, LinkId by);
  void link_gone(LinkId link) { links_.erase(link); }
  /// The participant has said which digests the records of the process have.
  void heartbeat_came(const RemoteParticipant& by, const PerRole<std::uint64_t>& digests, Time now);
  void record_came(Participant& of, Role role, const RecordKey& key);
  /// Something of what the process has is missing in the tables of the participant, or is too much.
  void suspect(Participant& participant);

  // Answers.

  std::size_t participants() const { return members_.size(); }
  /// The records of that role that hold, also withdrawn ones.
  const Records& records(Role role) const { return records_[role]; }
  /// True if all of the process that the last heartbeat counts has come by that link.
  bool is_complete_on(LinkId link) const;
  /// The same for any link but this one.
  bool is_complete_beside(LinkId link) const;
  /// Both are empty unless the process was found by a link and is not heard by it any more, though it is by
  /// another. A link that was cut stays so until the process is heard by it again, however long that takes.
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
  std::vector<Member> members_;                      ///< the one that was there first is the first
  std::set<LinkId> links_;                           ///< by which it has been found
  std::optional<PerRole<std::uint64_t>> digests_{};  ///< of the last heartbeat that counts
  PerRole<Records> records_{};
};

}  // namespace sft::core
