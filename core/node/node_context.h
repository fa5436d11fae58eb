// Shared by the endpoints of one node: the table of all endpoints, the transports, and ways to tell others
// and the user. The agent's.
#pragma once

#include "core/discovery/discovery.h"
#include "core/negotiation/negotiation.h"
#include "core/node/port_attempts.h"
#include "core/report/node_log.h"
#include "core/seam/transport.h"

namespace sft::core {

class VanillaAccess;

struct NodeContext {
  Negotiation& negotiation;
  Discovery& discovery;
  PortAttempts& attempts;
  NodeLog& log;
  SharedMemory* memory = nullptr;    ///< null if the node must not use it
  Network* network = nullptr;        ///< null if the node must not use the network
  VanillaAccess* vanilla = nullptr;  ///< null if unmodified DDS readers are not served
};

/// Tells the user what differs between the states that the user could have polled. `reported`: the state that
/// was told last. `read_status` returns the present one, and `differences` turns two states into events.
template <class Core, class Status, class ReadStatus, class Differences>
void report_events(Core& core, Status& reported, NodeLog& log, ReadStatus read_status,
                   Differences differences) {
  if (!core.events().is_set() && !log.wants(LogLevel::warning)) return;
  Status status = read_status();
  const std::vector<Event> events = differences(reported, status);
  reported = std::move(status);
  for (const Event& event : events) {
    log.write(core.spec().topic, event);
    core.events()(event);
  }
}

}  // namespace sft::core
