// The negotiation decides who gets what, by which path and under which mask. It is a pure state machine:
// events go in, desired states come out, and there is no I/O and no clock in it. The events become facts
// (known_facts.h), and the facts say what each of our writers should serve (serving.h) and what each of our
// readers should hear (hearing.h). The order of events therefore does not matter. negotiation.md has the
// rules as a table.
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
#include "core/negotiation/known_facts.h"
#include "core/negotiation/serving.h"
#include "core/negotiation/type_comparisons.h"
#include "core/platform/clock.h"
#include "core/seam/transport.h"

namespace sft::core {

/// Entries of other nodes beyond these are refused and counted (table_shares.h has the rules).
struct NegotiationLimits {
  std::size_t endpoints = 4096;
  std::chrono::seconds forget_lost_after{60};
  std::size_t of_announcer = 1024;
  std::size_t of_topic = 256;
};

class Negotiation {
 public:
  using Limits = NegotiationLimits;
  explicit Negotiation(const Limits& limits = {});

  // Events. Each returns whether anything may have changed, that is, whether to ask for the desired states
  // again. Most endpoints of a large system have topics that none of ours has: these change nothing.
  bool self_changed(const Self& self);
  /// Our endpoints are reached there from now on, and others from there.
  bool network_changed(const std::vector<UdpAddress>& addresses, const std::vector<Link>& links);
  /// `type` outlives the endpoint. The endpoint's host and network are taken from Self, its addresses from
  /// network_changed().
  void local_added(const Endpoint& endpoint, const TypeSupport& type);
  void local_removed(EndpointId id);
  // Discovery tells what it knows of the endpoints of others in its order: a request comes after its
  // endpoint, and what comes later holds.
  bool endpoint_seen(const Endpoint& endpoint);
  bool endpoint_departed(EndpointId id);
  bool endpoint_lost(EndpointId id, Time now);
  bool request_received(const Request& request);
  /// One of our readers needs other fields now.
  bool requirement_changed(EndpointId reader, const Selection& selection);
  bool rate_changed(EndpointId reader, std::uint32_t min_period_us);
  /// Tells that samples of a writer now arrive at one of our readers by that path, or no longer arrive.
  bool connection_changed(EndpointId reader, EndpointId writer, TransportKind path, bool connected);
  /// Something of a durable writer has come for one of our readers alone.
  bool history_began(EndpointId reader, EndpointId writer);
  /// Tells that all retained samples for that reader have arrived.
  bool history_came(EndpointId reader, EndpointId writer);
  /// All that one of our writers has sent to a late reader alone has left. Takes effect once the reader says
  /// that it has begun to come.
  bool history_given(EndpointId writer, EndpointId reader);
  /// Tells why the port of one of our writers cannot ring that reader's doorbell in shared memory; empty if
  /// it can.
  bool reach_changed(EndpointId writer, EndpointId reader, const std::string& why_not);
  bool tick(Time now);
  /// The desired states do not depend on it.
  void progressed(const Progress& progress) { facts_.table.progressed(progress); }

  // Desired states, from the facts as they are.
  Serving serving(EndpointId writer) const;
  std::vector<Hearing> hearing(EndpointId reader) const;
  /// Our endpoint as it should be announced, with the request in force.
  const Endpoint* local(EndpointId id) const;

  /// All endpoints, ours and others'. What it returns is valid until the next event.
  const EndpointTable& table() const { return facts_.table; }
  std::uint64_t definitions_compared() const { return comparisons_.compared(); }
  /// Announcements that were refused, because the table was full.
  std::uint64_t ignored() const { return facts_.table.refused(); }
  /// The same by the name of the node that they came from, where one was named, since this was last asked.
  std::map<std::string, std::uint64_t> take_refusals() { return facts_.table.take_refusals(); }

 private:
  bool admit(const Endpoint& newcomer, bool& concerns_ours);

  Limits limits_;
  KnownFacts facts_;
  mutable TypeComparisons comparisons_;
};

}  // namespace sft::core
