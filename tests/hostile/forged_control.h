// Participants of the control topics that can write any records, on the network and, for nodes of their own
// host, on the loopback. Together they act as one process, and receive what honest nodes announce.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "core/control/control.h"
#include "core/control/record_body.h"
#include "core/discovery/heartbeat.h"
#include "core/discovery/own_records.h"
#include "core/discovery/records.h"
#include "sft_control.h"
#include "tests/pairs/control_participant.h"

namespace sft::hostile {

class ForgedControl {
 public:
  /// Joins the domain of the honest nodes, 0, as a process with this id, on these interfaces. If the id is
  /// 0, the object only listens, and other nodes do not recognize it as a process. Throws if there is no
  /// network.
  explicit ForgedControl(core::ProcessId process = 0,
                         const std::vector<std::string>& interfaces = {"lo", "eth0"});
  ~ForgedControl();
  ForgedControl(const ForgedControl&) = delete;
  ForgedControl& operator=(const ForgedControl&) = delete;

  /// Returns all endpoints that honest nodes have announced, with the newest request of each reader.
  std::vector<core::Endpoint> heard();
  std::vector<core::Endpoint> heard(core::Role role);
  struct HeardRecord {
    core::Role role{};
    dds_guid_t writer{};
    sft_control_Record sample{};
  };
  /// Returns the newest records of other participants, including withdrawn records. Their bodies are valid
  /// until the next call.
  std::vector<HeardRecord> records_heard();
  /// Returns the other participants on the network, including those with certificates.
  std::vector<test::ControlParticipant::Other> participants() const;

  // Records in its own name, which may contain false statements about any endpoint.

  /// Announces an endpoint; for a reader also its request.
  void announce(const core::Endpoint& endpoint);
  void request(const core::Request& request);
  /// Writes these bytes as the announcement of the endpoint.
  void announce_bytes(core::Role role, core::EndpointId id, std::vector<std::byte> bytes);
  void inquire(std::uint64_t owner, const core::Inquiry& inquiry);
  /// Sends a report on the topic of reports to the nodes that inquire.
  void report(const core::NodeReport& report);
  /// Writes a sample in its own name. The digests of its heartbeats do not include this sample.
  void write_as_own(core::Role role, sft_control_Record sample);
  /// Sends a heartbeat if one is due.
  void live();
  /// Sends a heartbeat with these digests.
  void live(const core::PerRole<std::uint64_t>& digests);

  // Messages in the names of other participants.

  /// These functions write the sample unchanged on all links, or dispose of its key on all links. Names,
  /// keys and versions are not checked.
  void write_raw(core::Role role, const sft_control_Record& sample);
  void dispose(core::Role role, const sft_control_Record& key);
  /// Sends the heartbeat over the network.
  void send(const core::Heartbeat& heartbeat);
  /// Returns the heartbeats of other participants that have come over the network since the last call.
  std::vector<core::Heartbeat> overheard();

 private:
  struct Link;
  using RecordOf = std::tuple<core::ParticipantGuid, core::Role, core::RecordKey>;
  void listen();
  void note(const test::ControlParticipant::Came& came);
  void put(core::Role role, core::EndpointId id, core::RecordKind kind, std::vector<std::byte> bytes);

  std::vector<std::unique_ptr<Link>> links_;
  core::OwnRecords own_;
  std::map<RecordOf, test::ControlParticipant::Came> records_;
  std::map<core::EndpointId, core::Endpoint> heard_;
  std::map<core::EndpointId, core::Request> requests_;
};

/// The name of forged nodes.
inline constexpr const char* made_up = "made up";

/// Returns a reader that fits this writer, as another node would announce it. The reader requests all
/// fields, and receives at these addresses.
core::Endpoint made_up_reader(const core::Endpoint& writer, std::uint64_t id, std::uint64_t node,
                              std::vector<core::UdpAddress> addresses);
/// Returns a writer that fits this reader.
core::Endpoint made_up_writer(const core::Endpoint& reader, std::uint64_t id, std::uint64_t node);

}  // namespace sft::hostile
