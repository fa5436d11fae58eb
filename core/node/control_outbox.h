// What a node says of its endpoints on the control topics. What cannot be written is written again, ever more
// seldom, until it succeeds; what is said then is what holds by then. The agent's.
#pragma once

#include <map>

#include "core/discovery/discovery.h"
#include "core/negotiation/negotiation.h"
#include "core/platform/retry.h"
#include "core/report/node_log.h"

namespace sft::core {

class ControlOutbox {
 public:
  using Now = Retry::Now;

  /// All that it is given outlives it.
  ControlOutbox(Negotiation& negotiation, Discovery& discovery, NodeLog& log)
      : negotiation_(negotiation), discovery_(discovery), log_(log) {}

  /// One of our endpoints, as it is now.
  void announce(EndpointId id, Now now);
  /// The request of one of our readers, as it is now.
  void request(EndpointId reader, Now now);
  void withdraw(EndpointId id);
  /// Writes again what is due.
  void look(Now now);

 private:
  struct Unsaid {
    bool announcement = false;
    bool request = false;
    Retry retry;
  };
  void say(EndpointId id, Unsaid& unsaid, Now now);

  Negotiation& negotiation_;
  Discovery& discovery_;
  NodeLog& log_;
  std::map<EndpointId, Unsaid> unsaid_;  ///< of these something was not written
};

}  // namespace sft::core
