// The endpoints of other processes that somebody claims, by their ids and by their nodes. Pure.
#pragma once

#include <cstddef>
#include <iterator>
#include <map>
#include <set>
#include <utility>

#include "core/control/control.h"
#include "core/discovery/endpoint_claims.h"
#include "core/platform/clock.h"

namespace sft::core {

class ClaimedEndpoints {
 public:
  /// The context outlives this object.
  explicit ClaimedEndpoints(const ClaimContext& context) : context_(context) {}

  std::size_t size() const { return endpoints_.size(); }
  /// Null if nobody has claimed it.
  EndpointClaims* find(EndpointId id);
  /// The claims of that endpoint, which are none if nobody has claimed it.
  EndpointClaims& operator[](EndpointId id) { return endpoints_.try_emplace(id, context_).first->second; }
  /// Somebody has announced the endpoint for that node.
  void belongs_to(EndpointId id, NodeId node) { by_node_.emplace(node, id); }
  void erase(EndpointId id) { endpoints_.erase(id); }
  /// Forgets endpoints of which all claims ended before.
  void forget_before(Time before);

  template <class Use>
  void each(Use use) {
    for (auto& [id, claims] : endpoints_) use(claims);
  }
  template <class Use>
  void each(Use use) const {
    for (const auto& [id, claims] : endpoints_) use(id, claims);
  }

  // These functions return endpoints as they were told last. A pointer is valid until the next event.

  /// Null if nothing was told of it.
  const Endpoint* told(EndpointId id) const;
  /// Calls use(endpoint) for each endpoint that was told for that node, until it returns false.
  template <class Use>
  void each_told_of(NodeId node, Use use) const {
    for (auto one = by_node_.lower_bound({node, 0}); one != by_node_.end() && one->first == node; ++one) {
      const Endpoint* const told = this->told(one->second);
      if (told != nullptr && told->node_id == node && !use(*told)) return;
    }
  }
  /// True if the node's signs of life have ended. The announcements of its endpoints stay in force.
  bool is_silent(NodeId node) const { return context_.nodes.is_lost(node); }
  /// Null if nothing was told for that node.
  const Endpoint* some_told_of(NodeId node) const;

 private:
  bool is_claimed(EndpointId id, NodeId node);

  const ClaimContext& context_;
  std::map<EndpointId, EndpointClaims> endpoints_;
  /// This index is by the nodes for which endpoints were announced, since a sign of life of each node comes
  /// every second. Some of these endpoints are not known, or are not announced for that node, any more.
  std::set<std::pair<NodeId, EndpointId>> by_node_;
};

}  // namespace sft::core
