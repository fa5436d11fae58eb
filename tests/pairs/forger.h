// Somebody on the network who speaks for others on the control topics: with Cyclone DDS alone, as any program
// can, and with datagrams of RTPS in their participants' names.
#pragma once

#include <dds/dds.h>

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/discovery/pulse_socket.h"
#include "sft_control.h"

namespace sft::test {

class Forger {
 public:
  Forger();
  ~Forger() { dds_delete(participant_); }
  Forger(const Forger&) = delete;
  Forger& operator=(const Forger&) = delete;

  /// Withdraws all endpoints that it knows of.
  void withdraw_all();
  /// Says for all readers that they listen to nobody, in requests that are so far ahead of theirs.
  void mute_all(std::uint64_t ahead);
  /// Sends one sign of life in the name of each node's own writer of them, with a sequence number so far
  /// ahead that all that the writer says afterwards is old.
  void outdate_signs_of_life();
  /// Says in the name of each writer of announcements and requests that nothing before such a number is left.
  void outdate_announcements();
  /// Says for all readers that have made a request that they listen to nobody, as their own writers.
  void ask_for_nothing();
  /// Complains of all participants: that something else came in their names than what they say.
  void complain_of_all();
  /// Answers each pulse that has come on eth0 since the last call with others in the name of the same node
  /// and of one that is made up, which tell of other announcements and of full signs of life that nobody
  /// gave.
  void forge_pulses();
  /// Says that it is a node's participant whose control topics are of that version.
  void claim_version(unsigned version);

 private:
  void look();
  void set_user_data(const std::string& data);
  std::vector<dds_guid_t> participants_of_others();
  /// The writers of this topic that others have. Those of participants that hide them are guessed: their
  /// entities have the same numbers as those of others.
  std::vector<dds_guid_t> writers_of(const std::string& topic);

  dds_entity_t participant_ = 0;
  dds_entity_t participants_ = 0, publications_ = 0;  ///< readers
  struct Words {
    dds_entity_t reader = 0, writer = 0;
  };
  Words of_writers_, of_readers_;
  std::map<std::uint64_t, std::uint64_t>
      known_;  ///< the sequence of the newest request by endpoint; 0: a writer
  std::map<std::uint64_t, std::uint64_t> keys_;  ///< the key of each endpoint's announcement
  std::map<std::uint64_t, dds_guid_t> asks_by_;  ///< the writer of a reader's requests
  unsigned complaints_ = 0;
  std::optional<core::PulseSocket> pulses_;
};

}  // namespace sft::test
