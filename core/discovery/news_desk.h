// Passes the news that LinkMerge has made, and those of other nodes of this process, to the listeners.
#pragma once

#include <map>
#include <memory>
#include <vector>

#include "core/discovery/desired_links.h"
#include "core/discovery/discovery_news.h"
#include "core/discovery/process_nodes.h"

namespace sft::core {

class NewsDesk {
 public:
  using Links = std::map<LinkId, LinkSpec>;

  /// Both outlive this object.
  NewsDesk(const NodeListeners& to, const Links& links) : to_(to), links_(links) {}

  /// An endpoint whose description cannot be used loses the description and nothing more: programs that were
  /// compiled with the type do not need it.
  void operator()(const EndpointSeen& seen) const;
  void operator()(const EndpointDeparted& departed) const {
    tell([&](DiscoveryListener& listener) { listener.endpoint_departed(departed.id); });
  }
  void operator()(const EndpointLost& lost) const {
    tell([&](DiscoveryListener& listener) { listener.endpoint_lost(lost.id); });
  }
  void operator()(const NodeLost& lost) const {
    tell([&](DiscoveryListener& listener) { listener.node_lost(lost.id); });
  }
  void operator()(const Request& request) const {
    tell([&](DiscoveryListener& listener) { listener.request_received(request); });
  }
  void operator()(const Assertion& assertion) const {
    tell([&](DiscoveryListener& listener) { listener.liveliness_asserted(assertion); });
  }
  void operator()(const Refused& refused) const {
    tell([&](DiscoveryListener& listener) { listener.control_malformed(refused.why); });
  }

 private:
  template <class Tell>
  void tell(Tell tell) const {
    for (const std::shared_ptr<NodeListener>& member : to_) member->tell(tell);
  }
  void leave_out_what_is_cut(Endpoint& endpoint, const std::vector<LinkId>& silent) const;

  const NodeListeners& to_;
  const Links& links_;
};

}  // namespace sft::core
