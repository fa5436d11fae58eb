// The nodes of a process that share discovery: who of them is told what. A node is told of the endpoints that
// may match its own: those of the other role, of the same topic. A node that asks for a role is told of all
// its endpoints. What the nodes say themselves they tell each other without a network between. Pure: events
// and times go in, addressed news come out. One thread at a time, but for NodeListener.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/control/control.h"
#include "core/discovery/claimed_endpoints.h"
#include "core/discovery/discovery_listener.h"
#include "core/discovery/discovery_news.h"
#include "core/platform/clock.h"
#include "core/sync/guarded_call.h"

namespace sft::core {

/// A node that listens. Any thread.
class NodeListener {
 public:
  /// The listener outlives this object, or close().
  explicit NodeListener(DiscoveryListener& listener) : listener_(listener) {}

  /// Calls `tell(listener)`, unless it is closed.
  template <class Tell>
  void tell(Tell tell) {
    gate_.call([&] { tell(listener_); });
  }
  /// When it returns, the listener is not called any more.
  void close() { gate_.close(); }

 private:
  DiscoveryListener& listener_;
  CallGate gate_;
};

using NodeListeners = std::vector<std::shared_ptr<NodeListener>>;

struct AddressedNews {
  News news;
  std::shared_ptr<const NodeListeners> to;
};

class ProcessNodes {
 public:
  /// `lease`: after that without a sign of life a node of the process is lost to the others, too.
  explicit ProcessNodes(std::chrono::milliseconds lease) : lease_(lease) {}

  /// From now on the listener is a member: one of the nodes.
  void join(const std::shared_ptr<NodeListener>& member);
  /// The node of the member ends. It has withdrawn its endpoints before. Returns the node; 0 if that has
  /// never said anything.
  NodeId leave(const std::shared_ptr<NodeListener>& member);
  /// The member is told of all endpoints of that role from now on, and of those that others than members have
  /// (`known`).
  void hears_all(const std::shared_ptr<NodeListener>& member, Role role, const ClaimedEndpoints& known);

  // A member says something itself. The others are told. The member is told of the endpoints that there are
  // of a topic that it did not have before.
  void announced(const std::shared_ptr<NodeListener>& member, Endpoint endpoint,
                 const ClaimedEndpoints& known);
  void withdrawn(EndpointId id, const ClaimedEndpoints& known);
  void requested(const Request& request);
  void asserted(const std::shared_ptr<NodeListener>& member, Assertion assertion, Time now);

  /// The endpoints of a member that it has not withdrawn.
  std::vector<EndpointId> endpoints_of(const std::shared_ptr<NodeListener>& member) const;
  /// The nodes that have said since then that they live.
  std::vector<NodeId> living(Time since) const;
  bool has(NodeId node) const;
  /// An endpoint of a member. Null if there is none of that id.
  const Endpoint* find(EndpointId id) const;
  /// Calls use(endpoint) for each endpoint of a member.
  template <class Use>
  void each_own(Use use) const {
    for (const auto& [id, own] : own_) use(*own.endpoint);
  }

  /// Addresses what others have said to those whom it concerns. `known`: of endpoints that news are about.
  void pass_on(std::vector<News> news, const ClaimedEndpoints& known);
  void tick(Time now);

  /// Returns the addressed news in the order in which they happened.
  std::vector<AddressedNews> take() { return std::exchange(news_, {}); }

 private:
  struct Hearer {
    std::shared_ptr<NodeListener> member;
    AnnouncerId number = 0;
    std::set<Role> hears_all{};
    /// The topics of its endpoints of each role, and how many it has of each.
    std::map<Role, std::map<std::string, std::size_t>> topics{};
    std::set<EndpointId> endpoints{};
    NodeId node = 0;                 ///< once it has announced anything, or has said that it lives
    std::optional<Time> asserted{};  ///< when it has said last that it lives
    bool is_lost = false;            ///< its agent does nothing

    bool is_concerned_by(const Endpoint& endpoint) const;
  };
  struct Own {
    std::shared_ptr<NodeListener> by;
    std::shared_ptr<const Endpoint> endpoint;
    std::optional<Request> request{};  ///< the latest one since the announcement, if there is one
  };

  Hearer& of(const std::shared_ptr<NodeListener>& member);
  /// Returns the members for which `which(hearer)` is true.
  template <class Which>
  std::shared_ptr<const NodeListeners> members_that(Which which) const;
  std::shared_ptr<const NodeListeners> concerned_by(const News& news, const ClaimedEndpoints& known) const;
  std::shared_ptr<const NodeListeners> concerned_by(const Assertion& sign,
                                                    const std::vector<const Endpoint*>& endpoints,
                                                    const NodeListener* by) const;
  void tell(std::shared_ptr<const NodeListeners> members, News news);
  /// Tells of those endpoints of others that the member did not hear of before.
  void tell_what_is_in_force(const Hearer& hearer, const std::function<bool(const Endpoint&)>& is_new,
                             const ClaimedEndpoints& known);
  void tell_others(const Own& own, News news);
  void tell_all_others(const std::shared_ptr<NodeListener>& member, News news);

  const std::chrono::milliseconds lease_;
  /// The numbers of participants (participants.h) count from 1 on.
  AnnouncerId last_number_ = AnnouncerId{1} << 63;
  std::vector<Hearer> hearers_;
  std::map<EndpointId, Own> own_;
  std::vector<AddressedNews> news_;
};

}  // namespace sft::core
