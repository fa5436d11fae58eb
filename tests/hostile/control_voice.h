// Participants of the control topics that say whatever they like, on the network and, for nodes of their own
// host, on the loopback. They are one process, and hear what the honest ones announce.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "core/control/control.h"
#include "core/discovery/heartbeat.h"
#include "core/discovery/own_records.h"
#include "core/discovery/records.h"
#include "sft_control.h"

namespace sft::hostile {

class ControlVoice {
 public:
  /// Speaks in the domain that the honest nodes use, as a process with this id. With 0 it only listens, and
  /// is no process to others. Throws if there is no network.
  explicit ControlVoice(core::ProcessId process = 0);
  ~ControlVoice();
  ControlVoice(const ControlVoice&) = delete;
  ControlVoice& operator=(const ControlVoice&) = delete;

  /// Everything that honest nodes announced, with the newest request of each reader.
  std::vector<core::Endpoint> heard();
  std::vector<core::Endpoint> heard(core::Role role);
  /// The newest records of others, withdrawn ones included, as samples. The bodies are valid until the next
  /// call.
  std::vector<std::pair<core::Role, sft_control_Record>> records_heard();

  // Records of its own. They may say anything of anybody's endpoints.

  /// A reader's announcement comes with its request.
  void announce(const core::Endpoint& endpoint);
  void request(const core::Request& request);
  /// Writes these bytes as its announcement of the endpoint.
  void announce_bytes(core::Role role, core::EndpointId id, std::vector<std::byte> bytes);
  /// Gives a heartbeat if one is due.
  void live();

  // Whatever is not its own.

  /// Writes the sample as it is on all links: names, keys and versions are not checked.
  void write_raw(core::Role role, const sft_control_Record& sample);
  void dispose(core::Role role, const sft_control_Record& key);
  /// Calls `use(heartbeat, send)` for each heartbeat of others that has come by UDP since the last call;
  /// `send` sends another one by the same link.
  void answer_heartbeats(const std::function<void(const core::Heartbeat&,
                                                  const std::function<void(const core::Heartbeat&)>&)>& use);

 private:
  struct Link;
  using RecordOf = std::tuple<core::ParticipantGuid, core::Role, core::RecordKey>;
  void listen();
  void note(const RecordOf& of, const core::Record& record);
  void put(core::Role role, core::EndpointId id, core::RecordKind kind, std::vector<std::byte> bytes);

  std::vector<std::unique_ptr<Link>> links_;
  core::OwnRecords own_;
  std::map<RecordOf, core::Record> records_;
  std::map<core::EndpointId, core::Endpoint> heard_;
  std::map<core::EndpointId, core::Request> requests_;
};

/// The name of nodes that attackers make up.
inline constexpr const char* made_up = "made up";

/// A reader that would fit this writer, at an address, as another node would announce it. It asks for all
/// fields and listens to the writer.
core::Endpoint made_up_reader(const core::Endpoint& writer, std::uint64_t id, std::uint64_t node,
                              std::vector<core::UdpAddress> addresses);
/// A writer that would fit this reader.
core::Endpoint made_up_writer(const core::Endpoint& reader, std::uint64_t id, std::uint64_t node);

}  // namespace sft::hostile
