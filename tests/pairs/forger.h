// Somebody on the network who speaks for others on the control topics: with Cyclone DDS alone, as any program
// can, and with datagrams of RTPS in their participants' names.
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

  /// Disposes of all records of others, and writes for each that it was withdrawn.
  void withdraw_all();
  /// Says for all readers that they listen to nobody, in requests that are that far ahead of theirs: in the
  /// names of their participants, and of a process that announces the same readers.
  void mute_all(std::uint64_t ahead);
  /// Makes a participant for each other process that says it belongs to that one, which has none of its
  /// endpoints any more.
  void claim_processes();
  /// Says in the name of each writer of records that nothing before a great number is left.
  void outdate_announcements();
  /// Says for all readers that have made a request that they listen to nobody, as their own writers.
  void ask_for_nothing();
  /// Answers each heartbeat that has come on eth0 since the last call with others: in the same name, with the
  /// digests of other records, and in the name of a process that is made up.
  void forge_heartbeats();
  /// Sends a heartbeat by the topic in the name of each writer that may be one of it, with a sequence number
  /// so far ahead that all that the writer says afterwards is old.
  void outdate_heartbeats();
  /// Says that it is a participant whose control topics are of that version.
  void claim_version(unsigned version);

 private:
  using RecordOf = std::tuple<core::ParticipantGuid, core::Role, core::RecordKey>;
  struct Known {
    dds_guid_t writer{};
    core::Record record{};
  };

  void look();
  /// The writers of this topic that others have. Those of participants that hide them are guessed: their
  /// entities have the same numbers as those of others.
  std::vector<dds_guid_t> writers_of(const std::string& topic);

  ControlParticipant self_;                   ///< without user data: it belongs to no process
  dds_entity_t publications_ = 0;             ///< a reader
  std::map<RecordOf, Known> known_;           ///< the newest record of each key
  std::unique_ptr<ControlParticipant> twin_;  ///< of a process that announces the readers of others
  std::map<core::ProcessId, std::unique_ptr<ControlParticipant>> impostors_;
};

}  // namespace sft::test
