// An attacker on the network that writes in the names of other participants on the control topics. The
// attacker uses Cyclone DDS alone, as any program can, and RTPS datagrams in the names of these participants.
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

  /// Disposes of all records of other participants, and writes a withdrawal for each.
  void withdraw_all();
  /// Writes requests that list no writers, for all readers, so that no samples would be sent. The sequences
  /// are `ahead` of the true ones. The requests are in the names of the readers' participants, and in the
  /// name of a process that announces the same readers.
  void mute_all(std::uint64_t ahead);
  /// Makes a participant for each other process. The participant says that it belongs to that process, and
  /// withdraws all endpoints of the process.
  void impersonate_processes();
  /// Announces, in the name of each writer of records, that the writer has no samples before a great sequence
  /// number.
  void outdate_announcements();
  /// Writes requests that list no writers, for all readers that have made a request. The requests are in the
  /// names of the readers' own writers of records.
  void ask_for_nothing();
  /// Answers each heartbeat that has arrived on eth0 since the last call with two forged ones: one in the
  /// same name with digests of other records, and one in the name of a process that does not exist.
  void forge_heartbeats();
  /// Sends heartbeats on their topic in the name of each writer that may exist. The sequence number is so far
  /// ahead that Cyclone discards all later samples of the writer as old.
  void outdate_heartbeats();
  /// Announces a participant whose control topics have the given version.
  void announce_version(unsigned version);

 private:
  using RecordOf = std::tuple<core::ParticipantGuid, core::Role, core::RecordKey>;
  struct Known {
    dds_guid_t writer{};
    core::Record record{};
  };

  void look();
  /// Returns the writers of this topic that other participants have. The writers of a participant that hides
  /// them are guessed, because the entities of all participants have the same numbers.
  std::vector<dds_guid_t> writers_of(const std::string& topic);

  ControlParticipant self_;          ///< has no user data, so that it belongs to no process
  dds_entity_t publications_ = 0;    ///< the reader of Cyclone's publications
  std::map<RecordOf, Known> known_;  ///< the newest record of each key
  /// Belongs to a process that announces the readers of other processes.
  std::unique_ptr<ControlParticipant> twin_;
  std::map<core::ProcessId, std::unique_ptr<ControlParticipant>> impostors_;
};

}  // namespace sft::test
