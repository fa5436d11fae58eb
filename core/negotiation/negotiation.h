// The negotiation decides which readers get which samples, by which path and under which mask. It is a pure
// state machine: events are passed in, desired states are returned, and it uses no I/O and no clock. The
// events become facts: about this host, the endpoints, and the history that readers have got. From the facts
// follow the routes of each of our writers, and the writers from which each of our readers receives
// (desired_states.cpp). The order of events therefore does not matter. negotiation.md has the rules.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/control/control.h"
#include "core/negotiation/endpoint_table.h"
#include "core/negotiation/hearing.h"
#include "core/negotiation/history_state.h"
#include "core/negotiation/local_host.h"
#include "core/negotiation/serving.h"
#include "core/negotiation/type_comparisons.h"
#include "core/platform/clock.h"
#include "core/seam/transport.h"

namespace sft::core {

class Negotiation {
 public:
  /// The time for which the facts about a lost endpoint are kept.
  static constexpr std::chrono::seconds forget_lost_after{60};

  // Events. Each returns true if the desired states may have changed, so that they have to be read again.
  // Most endpoints of a large system have topics that no endpoint of ours has; events of these change
  // nothing.
  bool self_changed(const Self& self);
  /// Called when the addresses at which our endpoints are reached have changed, or the links by which other
  /// nodes are reached.
  bool network_changed(const std::vector<UdpAddress>& addresses, const std::vector<Link>& links);
  /// `type` must outlive the endpoint. The endpoint's host and network are taken from Self, its addresses
  /// from network_changed().
  void local_added(const Endpoint& endpoint, const TypeSupport& type);
  void local_removed(EndpointId id);
  // Discovery reports endpoints of other nodes in order: a request comes after its endpoint, and a later
  // report replaces an earlier one.
  bool endpoint_seen(const Endpoint& endpoint);
  bool endpoint_departed(EndpointId id);
  bool endpoint_lost(EndpointId id, Time now);
  bool request_received(const Request& request);
  /// Called when one of our readers needs other fields, parts, conditions, or another maximum rate.
  bool requirement_changed(EndpointId reader, const Wanted& wanted);
  /// Called when one of our readers now takes datagrams of a writer (`listening`), or is attached to its
  /// shared memory, or no longer does so.
  bool connection_changed(EndpointId reader, EndpointId writer, bool listening, bool attached);
  /// Called when the first sample of a durable writer for one of our readers alone has arrived.
  bool history_began(EndpointId reader, EndpointId writer);
  /// Called when all retained samples for that reader have arrived.
  bool history_came(EndpointId reader, EndpointId writer);
  /// Called when all samples that one of our writers sends to a late reader alone have left this process.
  /// Takes effect once the reader's request says that the first of these samples has arrived.
  bool history_given(EndpointId writer, EndpointId reader);
  bool tick(Time now);
  /// Stores the reported progress of a writer, on which no desired state depends.
  void progressed(const Progress& progress) { table_.progressed(progress); }

  // Desired states, derived from the present facts.
  /// The readers in shared memory whose doorbells the port of a writer cannot ring, with the reasons.
  using Unreachable = std::map<EndpointId, std::string>;
  Serving serving(EndpointId writer, const Unreachable& unreachable = {}) const;
  std::vector<Hearing> hearing(EndpointId reader) const;
  /// Returns our endpoint as it should be announced, with its request that is in force.
  const Endpoint* local(EndpointId id) const;

  /// Returns all endpoints, including those of other nodes. Pointers that the table returns are valid until
  /// the next event.
  const EndpointTable& table() const { return table_; }
  std::uint64_t definitions_compared() const { return comparisons_.compared(); }

 private:
  void erase(EndpointId id);

  LocalHost host_;
  EndpointTable table_;
  HistoryState history_;
  mutable TypeComparisons comparisons_;
};

}  // namespace sft::core
