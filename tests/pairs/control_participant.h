// A participant of the control topics that any program can make with Cyclone DDS alone: it says of itself
// what it likes, reads what others have and ask for, and writes records with any fields.
#pragma once

#include <dds/dds.h>

#include <functional>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/control/control.h"
#include "core/discovery/heartbeat_socket.h"
#include "core/discovery/records.h"
#include "sft_control.h"

namespace sft::test {

class ControlParticipant {
 public:
  /// In that domain of this process, which is domain 0 on the wire; heartbeats go by the interface. Process
  /// 0: the participant has no user data. Throws if Cyclone DDS or the system refuses it.
  ControlParticipant(dds_domainid_t domain, const std::string& interface, core::ProcessId process);
  ~ControlParticipant();
  ControlParticipant(const ControlParticipant&) = delete;
  ControlParticipant& operator=(const ControlParticipant&) = delete;

  /// A record of another participant.
  struct Came {
    core::Role role{};
    core::ParticipantGuid participant{};  ///< as the record says
    dds_guid_t writer{};
    core::RecordKey key{};
    core::Record record{};
  };
  /// Calls `use(came)` for each record that has come since the last call.
  void take(const std::function<void(const Came&)>& use);

  /// Writes a record of its own. Its heartbeats count it.
  void write(core::Role role, const core::RecordKey& key, core::Record record);
  /// Writes the sample as it is, and disposes of its key.
  void write_raw(core::Role role, const sft_control_Record& sample);
  void dispose(core::Role role, const sft_control_Record& key);
  /// Gives a heartbeat with the digests of its records.
  void give_heartbeat();

  /// Tells those that inquire. May get lost.
  void report(const core::NodeReport& report);
  /// Sends a heartbeat in any name, also to programs of its own host.
  void send(const core::Heartbeat& heartbeat);
  /// Returns the heartbeats of others that have come by UDP since the last call. Those that it has sent are
  /// none.
  std::vector<core::Heartbeat> overheard();

  /// Another participant, as it says of itself.
  struct Other {
    dds_guid_t guid{};
    std::string user_data{};
  };
  /// Returns the participants that are there, also those with certificates.
  std::vector<Other> others() const;

  void set_user_data(const std::string& data);
  dds_entity_t entity() const { return participant_; }
  const core::ParticipantGuid& guid() const { return guid_; }
  core::ProcessId process() const { return process_; }

 private:
  dds_entity_t participant_ = 0, participants_ = 0;  ///< itself, and a reader of others
  const core::ProcessId process_;
  core::ParticipantGuid guid_{};
  core::PerRole<dds_entity_t> readers_{}, writers_{};
  dds_entity_t report_writer_ = 0;
  core::PerRole<core::Records> records_{};
  std::optional<core::HeartbeatSocket> socket_;
  std::set<core::HeartbeatDatagram> sent_;
};

/// A sample with these fields. Its body is that of the record, which must outlive it.
sft_control_Record to_sample(const core::ParticipantGuid& participant, const core::RecordKey& key,
                             const core::Record& record);

core::RecordBody body_of(std::vector<std::byte> bytes);

}  // namespace sft::test
