// The DDS participant of this process on one link, in the Cyclone domain of that link. It writes and reads
// the topics of records, and sends and receives heartbeats.
#pragma once

#include <dds/dds.h>

#include <chrono>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "core/control/control.h"
#include "core/discovery/heartbeat_socket.h"
#include "core/discovery/own_records.h"
#include "core/discovery/participant_data.h"
#include "core/sync/mutex.h"
#include "sft/result.h"

namespace sft::core {

class CycloneDomain;
class KnownPeers;

class ControlLink {
 public:
  struct Place {
    LinkId link = 0;
    std::shared_ptr<const CycloneDomain> domain{};
    ProcessId process = 0;
    bool is_secured = false;  ///< the domain uses DDS Security
    /// The address of the heartbeat socket. Empty if heartbeats are sent through Cyclone only.
    std::optional<HeartbeatSocket::Place> heartbeats{};
  };
  /// `known` must outlive the link. It is notified of what other participants announce. Several of Cyclone's
  /// threads call it at the same time, and hold locks of Cyclone.
  static Result<std::unique_ptr<ControlLink>> open(const Place& place, KnownPeers& known);
  /// Waits until no such call is running.
  ~ControlLink();
  ControlLink(const ControlLink&) = delete;
  ControlLink& operator=(const ControlLink&) = delete;

  // An object must be used by only one thread at a time.

  /// Starts to read the records that other participants write for that role.
  Result<void> hear(Role role);
  /// Writes a record. If that fails, the record is kept for write_again().
  void write(Role role, const OwnRecords::Change& change);
  /// Writes the records that could not be written before. Opens the topic of heartbeats if use_topic() has
  /// failed before. Returns the error if either of them fails again.
  Result<void> write_again();
  void give_heartbeat(const PerRole<std::uint64_t>& digests);
  /// Opens or closes the reader and the writer of reports.
  Result<void> use_reports(bool reads, bool writes);
  /// Sends a report, which may get lost. It is dropped if no writer of reports is open.
  void give_report(std::span<const std::byte> body);
  /// Passes on the heartbeats that have come by UDP since the last call.
  void take_heartbeats(Time now);
  /// Starts to send and receive heartbeats by the topic as well, and announces this. If it fails,
  /// write_again() tries again.
  Result<void> use_topic();
  bool uses_topic() const { return data_.uses_topic; }
  /// Announces the participant to all others once more. If `asks` is true, the others are asked to announce
  /// themselves, too.
  void announce(bool asks);
  /// Waits until the other participants have acknowledged the written records, but no longer than
  /// `timeout`.
  void flush(std::chrono::milliseconds timeout);

 private:
  /// The DDS topic with the records of one role.
  struct Topic {
    ControlLink* link = nullptr;
    Role role{};
    dds_entity_t writer = 0, reader = 0;
  };

  ControlLink(const Place& place, KnownPeers& known);
  Result<void> open();
  Result<dds_entity_t> writer_of(Topic& topic);
  Result<void> try_to_write(Role role, const RecordKey& key, const Record& record);
  void say_user_data();
  void take_participants(dds_entity_t reader);
  void note_participant(const dds_builtintopic_participant_t& sample, const dds_sample_info_t& info)
      SFT_REQUIRES(taking_);
  void take_records(dds_entity_t reader, Topic& topic);
  void take_heartbeat_samples(dds_entity_t reader);
  void take_reports(dds_entity_t reader);
  dds_entity_t open_report_reader();
  std::optional<ParticipantGuid> participant_of(dds_entity_t reader, dds_instance_handle_t writer)
      SFT_REQUIRES(taking_);
  RemoteParticipant here(const ParticipantGuid& guid) const { return {place_.link, guid}; }

  const Place place_;
  KnownPeers& peers_;
  ParticipantData data_;
  dds_entity_t participant_ = 0;
  ParticipantGuid guid_{};
  std::optional<HeartbeatSocket> socket_;
  dds_entity_t heartbeat_writer_ = 0, report_topic_ = 0, report_writer_ = 0, report_reader_ = 0;
  PerRole<Topic> topics_;
  std::map<std::pair<Role, RecordKey>, Record> unwritten_;
  bool wants_topic_ = false;  ///< heartbeats should be sent by the topic as well

  /// Held while samples are taken and passed on, so that they are passed on in order.
  Mutex taking_;
  /// The participant of each DDS writer.
  std::map<dds_instance_handle_t, ParticipantGuid> writers_ SFT_GUARDED_BY(taking_);
};

}  // namespace sft::core
