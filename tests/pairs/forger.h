// An attacker on the network that writes in the names of others on the control topics: with Cyclone DDS
// alone, as any program can, and with datagrams of RTPS in the names of their participants.
#pragma once

#include <dds/dds.h>

#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "core/control/control.h"
#include "tests/pairs/control_participant.h"

namespace sft::test {

class Forger {
 public:
  Forger();
  ~Forger();
  Forger(const Forger&) = delete;
  Forger& operator=(const Forger&) = delete;

  /// Disposes of all records of others, and writes a withdrawal for each.
  void withdraw_all();
  /// Writes requests for all readers, as if they listened to no writer. The sequences are `ahead` of the
  /// true ones. The requests are in the names of the readers' participants, and of a process that announces
  /// the same readers.
  void mute_all(std::uint64_t ahead);
  /// Makes a participant for each other process, which claims to belong to that process, and withdraws all
  /// its endpoints.
  void claim_processes();
  /// Announces in the name of each writer of records that it has no samples before a great sequence number.
  void outdate_announcements();
  /// Writes requests for all readers that have made one, as if they listened to no writer. Uses the names of
  /// their own writers of records.
  void ask_for_nothing();
  /// Answers each heartbeat that has come on eth0 since the last call with forged ones: in the same name
  /// with digests of other records, and in the name of a process that does not exist.
  void forge_heartbeats();
  /// Sends heartbeats by their topic in the name of each writer that may exist. The sequence number is so
  /// far ahead that Cyclone takes all later samples of the writer for old.
  void outdate_heartbeats();
  /// Announces a participant whose control topics have that version.
  void claim_version(unsigned version);

 private:
  using RecordOf = std::tuple<core::ParticipantGuid, core::Role, core::RecordKey>;
  struct Known {
    dds_guid_t writer{};
    core::Record record{};
  };

  void look();
  /// Returns the writers of this topic that other participants have. If a participant hides its writers they
  /// are guessed, because their entities have the same numbers as those of others.
  std::vector<dds_guid_t> writers_of(const std::string& topic);

  ControlParticipant self_;                   ///< without user data, so that it belongs to no process
  dds_entity_t publications_ = 0;             ///< a reader
  std::map<RecordOf, Known> known_;           ///< the newest record of each key
  std::unique_ptr<ControlParticipant> twin_;  ///< its process announces the readers of others
  std::map<core::ProcessId, std::unique_ptr<ControlParticipant>> impostors_;
};

}  // namespace sft::test
