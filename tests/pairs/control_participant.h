// A participant of the control topics that any program can make with Cyclone DDS alone. The participant can
// announce anything about itself, read the records of other participants, and write records with any fields.
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
  /// Joins `domain`, which is a number within this process and stands for domain 0 on the network. Heartbeats
  /// are sent and received on `interface`. If `process` is 0, the participant has no user data. Throws if
  /// Cyclone DDS or the system refuses.
  ControlParticipant(dds_domainid_t domain, const std::string& interface, core::ProcessId process);
  ~ControlParticipant();
  ControlParticipant(const ControlParticipant&) = delete;
  ControlParticipant& operator=(const ControlParticipant&) = delete;

  /// A record of another participant.
  struct Came {
    core::Role role{};
    core::ParticipantGuid participant{};  ///< the owner that the record names
    dds_guid_t writer{};
    core::RecordKey key{};
    core::Record record{};
  };
  /// Calls `use(came)` for each record that has arrived since the last call.
  void take(const std::function<void(const Came&)>& use);

  /// Writes a record of this participant. Its heartbeats count the record.
  void write(core::Role role, const core::RecordKey& key, core::Record record);
  /// Writes the sample unchanged, or disposes of its key.
  void write_raw(core::Role role, const sft_control_Record& sample);
  void dispose(core::Role role, const sft_control_Record& key);
  /// Sends a heartbeat with the digests of this participant's records.
  void give_heartbeat();

  /// Sends a report to the nodes that inquire. The report may be lost.
  void report(const core::NodeReport& report);
  /// Sends a heartbeat in the name of any participant. Programs on this host receive the heartbeat, too.
  void send(const core::Heartbeat& heartbeat);
  /// Returns the heartbeats of other participants that have arrived by UDP since the last call.
  std::vector<core::Heartbeat> overheard();

  /// The announcement of another participant.
  struct Other {
    dds_guid_t guid{};
    std::string user_data{};
  };
  /// Returns the other participants, including those with certificates.
  std::vector<Other> others() const;

  void set_user_data(const std::string& data);
  dds_entity_t entity() const { return participant_; }
  const core::ParticipantGuid& guid() const { return guid_; }
  core::ProcessId process() const { return process_; }

 private:
  /// This participant, and its reader of the other participants.
  dds_entity_t participant_ = 0, participants_ = 0;
  const core::ProcessId process_;
  core::ParticipantGuid guid_{};
  core::PerRole<dds_entity_t> readers_{}, writers_{};
  dds_entity_t report_writer_ = 0;
  core::PerRole<core::Records> records_{};
  std::optional<core::HeartbeatSocket> socket_;
  std::set<core::HeartbeatDatagram> sent_;
};

/// Returns a sample with these fields. The sample refers to the body of `record`, which must outlive the
/// sample.
sft_control_Record to_sample(const core::ParticipantGuid& participant, const core::RecordKey& key,
                             const core::Record& record);

core::RecordBody body_of(std::vector<std::byte> bytes);

}  // namespace sft::test
