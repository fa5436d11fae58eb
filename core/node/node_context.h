// The objects that the endpoints of one node share: the table of all endpoints, discovery, the transports,
// and the log. Used by the agent only.
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
  SharedMemory* memory = nullptr;    ///< null if the node must not use shared memory
  Network* network = nullptr;        ///< null if the node must not use the network
  VanillaAccess* vanilla = nullptr;  ///< null if the node exchanges no samples with unmodified DDS nodes
};

/// Reports the differences between the present state and the last reported one to the user, as events.
/// `reported` is the last reported state, and is set to the present one. `read_status` returns the present
/// state, and `differences` turns the two states into events.
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
