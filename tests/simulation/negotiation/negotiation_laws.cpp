#include "tests/simulation/negotiation/negotiation_laws.h"

#include <algorithm>

#include "tests/unit/core/control/endpoint_ids.h"

namespace sft::test {

using core::Endpoint;
using core::Role;
using core::Route;

namespace {

const Route* route_to(const std::vector<Route>& routes, core::EndpointId reader) {
  const auto found =
      std::find_if(routes.begin(), routes.end(), [&](const Route& r) { return r.reader == reader; });
  return found == routes.end() ? nullptr : &*found;
}

/// Returns true if the two policies in which the world's endpoints differ fit each other.
bool fits(const core::Qos& offered, const core::Qos& requested) {
  return offered.reliability >= requested.reliability && offered.durability >= requested.durability;
}

/// Returns the number of retained samples that a writer has to send to the reader first.
std::uint32_t retained_for(const core::Qos& offered, const core::Qos& requested) {
  const bool durable = offered.durability == Durability::transient_local &&
                       requested.durability == Durability::transient_local;
  return durable ? std::min(offered.history_depth, requested.history_depth) : 0;
}

}  // namespace

/// Checks that the writer serves exactly the readers that its node knows. Each reader must be served under
/// the newest selection and rate that the node has received, and by a path on which the reader is known to
/// listen.
void NegotiationLaws::check_serving(const WorldNode& node, const WorldWriter& writer) {
  std::size_t routes = 0;
  for (const auto& [id, reported] : node.reported) {
    const bool here = !reported.lost() && reported.endpoint->role == Role::reader;
    if (here) routes += check_route(node, writer, *reported.endpoint, reported.newest);
  }
  for (const auto& [id, reader] : node.readers) {
    const Endpoint& own = *node.negotiation.local(id);
    routes += check_route(node, writer, own, own.request.sequence);
  }
  if (routes != writer.wanted.memory.size() + writer.wanted.network.size() ||
      writer.wanted.fallback.size() > writer.wanted.memory.size()) {
    fail("a reader is served that is not there, or twice");
  }
}

/// Checks the routes to one reader. Returns the number of routes that the reader should have.
std::size_t NegotiationLaws::check_route(const WorldNode& node, const WorldWriter& writer,
                                         const Endpoint& reader, std::uint64_t newest) {
  const AskedRequests::Asked& asked = asked_.at(reader.id, newest);
  const Id w = writer.endpoint.id;
  const bool memory = writer.endpoint.may_use_memory && reader.may_use_memory && node.self.host.known() &&
                      reader.host == node.self.host;
  const bool network = writer.endpoint.may_use_network && reader.may_use_network;
  const bool matches = fits(writer.endpoint.qos, reader.qos);
  const std::uint32_t owed =
      writer.history_given.contains(reader.id) ? 0 : retained_for(writer.endpoint.qos, reader.qos);
  const bool history_first = owed != 0 && network;
  const bool shm = matches && memory && !history_first && holds(asked.request.attached, w);
  const bool udp = matches && !shm && network && holds(asked.request.listening, w);
  const Route* by_shm = route_to(writer.wanted.memory, reader.id);
  const Route* by_udp = route_to(writer.wanted.network, reader.id);
  const Route* fallback = route_to(writer.wanted.fallback, reader.id);
  if ((fallback != nullptr) != (shm && network && holds(asked.request.listening, w)))
    fail("by UDP what shared memory does not take: unasked, or not");
  if ((by_shm != nullptr) != shm) fail("in shared memory: served unasked, or not served");
  if ((by_udp != nullptr) != udp) fail("by UDP: served unasked, or not served");
  for (const Route* route : {by_shm, by_udp, fallback}) {
    if (route == nullptr) continue;
    if (!(route->selection == asked.selection)) fail("not the newest selection that the reader asked for");
    if (route->min_period_us != asked.request.min_period_us) fail("not the newest rate that it asked for");
    // The fallback route of a reader in shared memory never carries a history.
    const bool has_it = shm && (route == fallback || holds(asked.request.begun, w));
    if (route->history != (has_it ? 0 : owed)) fail("not what it is owed of the history");
  }
  return shm || udp ? 1 : 0;
}

void NegotiationLaws::check_agreement(const std::vector<WorldNode>& nodes) {
  std::size_t endpoints = 0;
  for (const WorldNode& node : nodes) endpoints += node.up ? node.writers.size() + node.readers.size() : 0;
  for (const WorldNode& there : nodes) {
    if (!there.up) continue;
    if (there.negotiation.table().size() != endpoints)
      fail("endpoints are known that are gone, or are not known");
    for (const auto& [id, writer] : there.writers) {
      for (const WorldNode& here : nodes) {
        if (!here.up) continue;
        for (const auto& [reader_id, reader] : here.readers) check_pair(there, writer, here, reader);
      }
    }
  }
}

/// Checks both sides of a pair at rest. If the policies fit, the reader must be served by the best path that
/// both sides have, under exactly the selection and rate that the reader requests. If the policies do not
/// fit, the reader must not be served. The history must have been given if that is possible.
void NegotiationLaws::check_pair(const WorldNode& there, const WorldWriter& writer, const WorldNode& here,
                                 const WorldReader& reader) {
  const Endpoint& w = writer.endpoint;
  const Endpoint& r = reader.endpoint;
  const bool memory =
      w.may_use_memory && r.may_use_memory && there.self.host.known() && there.self.host == here.self.host;
  const bool network = w.may_use_network && r.may_use_network;
  const bool matches = fits(w.qos, r.qos);
  const bool shm = matches && memory;
  const bool udp = matches && !memory && network;
  const Route* by_shm = route_to(writer.in_force.memory, r.id);
  const Route* by_udp = route_to(writer.in_force.network, r.id);
  if ((by_shm != nullptr) != shm || (by_udp != nullptr) != udp) fail("at rest, but not by the best path");
  const Route* route = by_shm != nullptr ? by_shm : by_udp;
  if (route != nullptr && !(route->selection == asked_.last(r.id).selection))
    fail("at rest, but under another selection");
  if (route != nullptr && route->min_period_us != asked_.last(r.id).request.min_period_us)
    fail("at rest, but at another rate");
  const bool durable = matches && network && retained_for(w.qos, r.qos) != 0;
  if (writer.history_given.contains(r.id) != durable) fail("at rest, but the history was not given");
  if (shm && !holds(reader.fed, w.id)) fail("served in memory, but not attached");
  if (udp && !holds(reader.connected, w.id)) fail("served by UDP, but not listening");
  for (const core::Hearing& hearing : here.negotiation.hearing(r.id)) {
    if (hearing.source.writer != w.id) continue;
    if (hearing.status.matched != (shm || udp)) fail("the reader thinks otherwise");
    const TransportKind kind = shm ? TransportKind::shm : TransportKind::udp;
    if (hearing.status.matched && hearing.status.transport != kind) fail("the reader thinks of another path");
  }
}

/// Checks that the reader of a datagram listens to the writer, and that the reader has requested the
/// datagram's selection at some time. A datagram names the selection under which it is decoded.
void NegotiationLaws::check_arrival(const std::vector<WorldNode>& nodes, const Datagram& datagram) {
  for (const WorldNode& node : nodes) {
    const auto reader = node.readers.find(datagram.reader);
    if (!node.up || reader == node.readers.end()) continue;
    if (holds(reader->second.let_go, datagram.writer)) continue;
    if (!holds(reader->second.connected, datagram.writer))
      fail("a sample came to a reader that does not listen");
    if (!asked_.has_ever_asked_for(datagram.reader, datagram.selection))
      fail("a sample came under a selection that its reader never asked for");
  }
}

}  // namespace sft::test
