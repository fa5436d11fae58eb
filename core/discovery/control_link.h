// The DDS participant of this process on one link, in the Cyclone domain of that link. It writes and reads
// the topics of records, and sends and receives heartbeats.
#pragma once

#include <dds/dds.h>

#include <chrono>
#include <cstdint>
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

/// The kinds of data that the links of a process exchange with others, beside heartbeats and the records that
/// they write.
struct LinkUse {
  PerRole<bool> reads_records{};
  bool reads_reports = false, writes_reports = false;
};

class ControlLink {
 public:
  struct Place {
    LinkId link = 0;
    std::shared_ptr<const CycloneDomain> domain{};
    ProcessId process = 0;
    bool is_secured = false;  ///< the domain uses DDS Security
    LinkSpec spec{};
    std::optional<std::uint16_t> heartbeat_port{};  ///< empty: heartbeats are sent through Cyclone only
  };
  /// `known` must outlive the link. It is notified of what other participants announce. Several of Cyclone's
  /// threads call it at the same time, and hold locks of Cyclone.
  static Result<std::unique_ptr<ControlLink>> open(const Place& place, KnownPeers& known);
  /// Waits until no such call is running.
  ~ControlLink();
  ControlLink(const ControlLink&) = delete;
  ControlLink& operator=(const ControlLink&) = delete;

  // An object must be used by only one thread at a time.

  /// Opens and closes readers and writers as `use` requires. Does what failed before again, except writes.
  Result<void> follow(const LinkUse& use);
  /// Writes a record. If that fails, the record is kept for write_again().
  void write(Role role, const OwnRecords::Change& change);
  /// Writes the records that could not be written before. Returns the error if that fails again.
  Result<void> write_again();
  void give_heartbeat(const PerRole<std::uint64_t>& digests);
  /// Sends a report, which may get lost. It is dropped if no writer of reports is open.
  void give_report(std::span<const std::byte> body);
  /// Passes on the heartbeats that have come by UDP since the last call.
  void take_heartbeats(Time now);
  /// Starts to send and receive heartbeats by the topic as well, and announces this. If it fails, follow()
  /// tries again.
  Result<void> use_topic();
  /// Announces the participant to all others once more. If `asks` is true, the others are asked to announce
  /// themselves, too.
  void announce(bool asks);
  /// Waits until the other participants have acknowledged the written records, but no longer than
  /// `timeout`.
  void flush(std::chrono::milliseconds timeout);

 private:
  /// A DDS topic, and its endpoints in our participant.
  struct Topic {
    const dds_topic_descriptor_t* type = nullptr;
    const char* name = nullptr;
    bool is_reliable = false;  ///< samples arrive, and are kept for participants that are found later
    dds_on_data_available_fn take = nullptr;
    dds_entity_t topic = 0, writer = 0, reader = 0;  ///< 0 if it is not open
  };

  ControlLink(const Place& place, KnownPeers& known);
  static ControlLink& of(void* listener) { return *static_cast<ControlLink*>(listener); }
  Result<void> open();
  Result<void> use(Topic& topic, bool reads, bool writes);
  Result<void> try_to_write(Role role, const RecordKey& key, const Record& record);
  void say_user_data();
  void take_participants(dds_entity_t reader);
  void note_participant(const dds_builtintopic_participant_t& sample, const dds_sample_info_t& info)
      SFT_REQUIRES(taking_);
  void take_records(dds_entity_t reader, Role role);
  void take_heartbeat_samples(dds_entity_t reader);
  void take_reports(dds_entity_t reader);
  std::optional<ParticipantGuid> participant_of(dds_entity_t reader, dds_instance_handle_t writer)
      SFT_REQUIRES(taking_);
  template <class Sample, class Use>
  void take(dds_entity_t reader, Use use);
  RemoteParticipant here(const ParticipantGuid& guid) const { return {place_.link, guid}; }

  const Place place_;
  KnownPeers& peers_;
  ParticipantData data_;
  dds_entity_t participant_ = 0;
  ParticipantGuid guid_{};
  std::optional<HeartbeatSocket> socket_;
  PerRole<Topic> records_;
  Topic heartbeats_, reports_;
  std::map<std::pair<Role, RecordKey>, Record> unwritten_;
  bool wants_topic_ = false;  ///< heartbeats should be sent by the topic as well

  /// Held while samples are taken and passed on, so that they are passed on in order.
  Mutex taking_;
  /// The participant of each DDS writer.
  std::map<dds_instance_handle_t, ParticipantGuid> writers_ SFT_GUARDED_BY(taking_);
};

}  // namespace sft::core
