// Writes what a node says of its endpoints to the control topics. A sample that cannot be written is tried
// again, ever more seldom, until that succeeds, and then tells what holds by then. The agent's.
#pragma once

#include <map>

#include "core/discovery/discovery.h"
#include "core/negotiation/negotiation.h"
#include "core/platform/clock.h"
#include "core/platform/retry.h"
#include "core/report/node_log.h"

namespace sft::core {

class ControlOutbox {
 public:
  /// All that it is given outlives it.
  ControlOutbox(Negotiation& negotiation, Discovery& discovery, NodeLog& log)
      : negotiation_(negotiation), discovery_(discovery), log_(log) {}

  /// Announces one of our endpoints as it is now.
  void announce(EndpointId id, Time now);
  /// Sends the request of one of our readers as it is now.
  void request(EndpointId reader, Time now);
  void withdraw(EndpointId id);
  /// Tries again what is due.
  void look(Time now);

 private:
  struct Unsaid {
    bool announcement = false;
    bool request = false;
    Retry retry;
  };
  void say(EndpointId id, Unsaid& unsaid, Time now);

  Negotiation& negotiation_;
  Discovery& discovery_;
  NodeLog& log_;
  std::map<EndpointId, Unsaid> unsaid_;  ///< endpoints with something that was not written yet
};

}  // namespace sft::core
