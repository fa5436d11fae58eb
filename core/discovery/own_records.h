// The records of this process, their slots, and when a heartbeat is due. Uses no clock, thread or I/O. An
// object must be used by only one thread at a time.
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

  /// A record that has changed and has to be written to all links.
  struct Change {
    RecordKey key{};
    Record record{};
  };
  /// Enters a record of `owner`, which is the number of an endpoint or an inquiry. Returns nothing if the
  /// record has not changed.
  std::optional<Change> put(Role role, std::uint64_t owner, RecordKind kind, std::vector<std::byte> body,
                            Time now);
  /// Withdraws all records of the owner, whose slot may then be used for another owner.
  std::vector<Change> withdraw(Role role, std::uint64_t owner, Time now);
  /// Returns all records that other processes should have, including withdrawn ones.
  const Records& records(Role role) const { return of_role_[role].records; }

  ProcessId process() const { return process_; }
  PerRole<std::uint64_t> digests() const {
    return {of_role_.writer.records.digest(), of_role_.reader.records.digest()};
  }
  /// Returns when the next heartbeat is due. A heartbeat follows each change, and a second one confirms it.
  /// A process whose table disagrees with two heartbeats knows that a record is missing.
  Time heartbeat_due() const;
  /// Returns true if the heartbeat is due. If no record has changed, returns true a little earlier than
  /// that, so that an agent that wakes up about once a second need not wake up once more for the heartbeat.
  bool is_heartbeat_due(Time now) const;
  void heartbeat_given(Time now);

 private:
  struct OfRole {
    Records records;
    std::map<std::uint64_t, std::uint32_t> slots;  ///< the slot of each owner
    std::vector<std::uint32_t> free;
    std::uint32_t slots_made = 0;
  };
  static std::uint32_t slot_of(OfRole& of_role, std::uint64_t owner);
  Change enter(OfRole& of_role, const RecordKey& key, RecordBody body, Time now);

  const ProcessId process_;
  const Timing timing_;
  PerRole<OfRole> of_role_;
  std::uint64_t revision_ = 0;
  std::optional<Time> changed_at_;  ///< the time of the first change since the last heartbeat
  std::optional<Time> given_at_;    ///< the time of the last heartbeat
  bool confirms_ = false;           ///< the last heartbeat was the first one after a change
};

}  // namespace sft::core
