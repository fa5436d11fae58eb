// The records of this process, the slots that they have, and when a heartbeat is due. Pure. One thread at a
// time.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "core/discovery/records.h"
#include "core/discovery/timing.h"
#include "core/platform/clock.h"

namespace sft::core {

class OwnRecords {
 public:
  OwnRecords(ProcessId process, const Timing& timing) : process_(process), timing_(timing) {}

  /// A record that has to be written to all links.
  struct Change {
    RecordKey key{};
    Record record{};
  };
  /// Enters a record of an endpoint, or of whatever else `owner` names. Returns nothing if the record says
  /// what it said before.
  std::optional<Change> put(Role role, std::uint64_t owner, RecordKind kind, std::vector<std::byte> body,
                            Time now);
  /// Withdraws all records of the owner, whose slot is used again.
  std::vector<Change> withdraw(Role role, std::uint64_t owner, Time now);
  /// All that others should know, also what was withdrawn.
  const Records& records(Role role) const { return of_role_[role].records; }

  ProcessId process() const { return process_; }
  PerRole<std::uint64_t> digests() const {
    return {of_role_.writer.records.digest(), of_role_.reader.records.digest()};
  }
  /// A heartbeat follows each change, and another one confirms it: who has read two heartbeats that count
  /// what did not arrive knows that it is missing.
  Time heartbeat_due() const;
  /// True also a little earlier unless something has changed: an agent that looks nearly once a second does
  /// not have to wake up for the heartbeat besides.
  bool is_heartbeat_due(Time now) const;
  void heartbeat_given(Time now);

 private:
  struct OfRole {
    Records records;
    std::map<std::uint64_t, std::uint32_t> slots;  ///< by the owner
    std::vector<std::uint32_t> free;
    std::uint32_t slots_made = 0;
  };
  static std::uint32_t slot_of(OfRole& of_role, std::uint64_t owner);
  Change enter(OfRole& of_role, const RecordKey& key, RecordBody body, Time now);

  const ProcessId process_;
  const Timing timing_;
  PerRole<OfRole> of_role_;
  std::uint64_t revision_ = 0;
  std::optional<Time> changed_at_;  ///< the first change since the last heartbeat
  std::optional<Time> given_at_;    ///< the last heartbeat
  bool confirms_ = false;           ///< the last heartbeat was the first one after a change
};

}  // namespace sft::core
