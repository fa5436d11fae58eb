// A participant of the control topics that any program can make with Cyclone DDS alone. It may announce
// anything about itself, reads the records of others, and writes records with any fields.
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
  /// Joins `domain`, a number within this process for domain 0 on the network. Heartbeats go by `interface`.
  /// If `process` is 0, the participant has no user data. Throws if Cyclone DDS or the system refuses.
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
  /// Calls `use(came)` for each record that has come since the last call.
  void take(const std::function<void(const Came&)>& use);

  /// Writes a record of its own, which its heartbeats count.
  void write(core::Role role, const core::RecordKey& key, core::Record record);
  /// Write the sample as it is, or dispose of its key.
  void write_raw(core::Role role, const sft_control_Record& sample);
  void dispose(core::Role role, const sft_control_Record& key);
  /// Sends a heartbeat with the digests of its own records.
  void give_heartbeat();

  /// Sends a report to the nodes that inquire. The report may get lost.
  void report(const core::NodeReport& report);
  /// Sends a heartbeat in the name of any participant, also to programs on its own host.
  void send(const core::Heartbeat& heartbeat);
  /// Returns the heartbeats of others that have come by UDP since the last call. Those that it has sent
  /// itself do not count.
  std::vector<core::Heartbeat> overheard();

  /// Another participant, as it announces itself.
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
  dds_entity_t participant_ = 0, participants_ = 0;  ///< this participant, and a reader of others
  const core::ProcessId process_;
  core::ParticipantGuid guid_{};
  core::PerRole<dds_entity_t> readers_{}, writers_{};
  dds_entity_t report_writer_ = 0;
  core::PerRole<core::Records> records_{};
  std::optional<core::HeartbeatSocket> socket_;
  std::set<core::HeartbeatDatagram> sent_;
};

/// Returns a sample with these fields. Its body is that of the record, which must outlive the sample.
sft_control_Record to_sample(const core::ParticipantGuid& participant, const core::RecordKey& key,
                             const core::Record& record);

core::RecordBody body_of(std::vector<std::byte> bytes);

}  // namespace sft::test
