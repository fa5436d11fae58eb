// Passes the news that LinkMerge has made to the listener of discovery.
#pragma once

#include <map>
#include <vector>

#include "core/discovery/desired_links.h"
#include "core/discovery/discovery_listener.h"
#include "core/discovery/link_merge.h"

namespace sft::core {

class NewsDesk {
 public:
  using Links = std::map<LinkId, LinkSpec>;

  /// Both outlive this object.
  NewsDesk(DiscoveryListener& listener, const Links& links) : listener_(listener), links_(links) {}

  /// An endpoint whose description cannot be used loses the description and nothing more: programs that were
  /// compiled with the type do not need it.
  void operator()(const EndpointSeen& seen) const;
  void operator()(const EndpointDeparted& departed) const { listener_.endpoint_departed(departed.id); }
  void operator()(const EndpointLost& lost) const { listener_.endpoint_lost(lost.id); }
  void operator()(const NodeLost& lost) const { listener_.node_lost(lost.id); }
  void operator()(const Request& request) const { listener_.request_received(request); }
  void operator()(const Assertion& assertion) const { listener_.liveliness_asserted(assertion); }
  void operator()(const Refused& refused) const { listener_.control_malformed(refused.why); }

 private:
  void leave_out_what_is_cut(Endpoint& endpoint, const std::vector<LinkId>& silent) const;

  DiscoveryListener& listener_;
  const Links& links_;
};

}  // namespace sft::core
