// These checks must hold in the world after each step, and at rest.
#include <algorithm>

#include "tests/simulation/negotiation/negotiation_world.h"
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

/// The two policies that the world's endpoints differ in; both sides judge by what was announced.
bool fits(const core::Qos& offered, const core::Qos& requested) {
  return offered.reliability >= requested.reliability && offered.durability >= requested.durability;
}

/// Retained samples that the reader is to get of a writer that has not given them yet.
std::uint32_t retained_for(const core::Qos& offered, const core::Qos& requested) {
  const bool durable = offered.durability == Durability::transient_local &&
                       requested.durability == Durability::transient_local;
  return durable ? std::min(offered.history_depth, requested.history_depth) : 0;
}

}  // namespace

/// Exactly those readers are served that were told to be there, each under the newest mask and rate that it
/// was told to want, and by a path that it is known to listen on.
void NegotiationWorld::check_serving(const Node& node, const Writer& writer) {
  std::size_t routes = 0;
  for (const auto& [id, told] : node.told) {
    const bool here = told.endpoint != nullptr && !told.lost() && told.endpoint->role == Role::reader;
    if (here) routes += check_route(node, writer, *told.endpoint, told.newest);
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

/// The number of routes that there should be.
std::size_t NegotiationWorld::check_route(const Node& node, const Writer& writer, const Endpoint& reader,
                                          std::uint64_t newest) {
  const Asked& asked = asked_.at(reader.id).at(newest);
  const Id w = writer.endpoint.id;
  const bool memory = writer.endpoint.may_use_shm && reader.may_use_shm && node.self.host.known() &&
                      reader.host == node.self.host;
  const bool network = writer.endpoint.may_use_udp && reader.may_use_udp;
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
    if (!(route->mask == asked.mask)) fail("not the newest mask that the reader asked for");
    if (route->min_period_us != asked.request.min_period_us) fail("not the newest rate that it asked for");
    // A fallback route, of a reader in shared memory, never has one.
    const bool has_it = shm && (route == fallback || holds(asked.request.begun, w));
    if (route->history != (has_it ? 0 : owed)) fail("not what it is owed of the history");
  }
  return shm || udp ? 1 : 0;
}

void NegotiationWorld::settle() {
  find_all_that_are_up();
  for (int round = 0; violation_.empty(); ++round) {
    if (round == 100) return fail("it does not come to rest");
    const bool delivered = deliver_all();
    const bool connected = connect_all();
    const bool given = give_all();
    if (!delivered && !connected && !given) break;
  }
  if (violation_.empty()) check_agreement();
}

void NegotiationWorld::find_all_that_are_up() {
  std::vector<std::pair<std::size_t, std::size_t>> ends;
  for (const auto& [pair, c] : channels_) ends.push_back(pair);
  for (const auto& [from, to] : ends) {
    if (nodes_[from].up && !channel(from, to).found) find(from, to);
    if (nodes_[from].up) hear_again(from, to);
    if (nodes_[from].up) continue;
    if (channel(from, to).found) lose(from, to);
  }
  deliver_all();
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    if (nodes_[n].up) forget(n);
  }
}

bool NegotiationWorld::deliver_all() {
  bool any = false;
  for (auto& [ends, c] : channels_) {
    for (; !c.announcements.empty(); c.announcements.pop_front())
      deliver(ends.second, c.announcements.front());
    for (; !c.requests.empty(); c.requests.pop_front()) deliver(ends.second, *c.requests.front());
  }
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    if (!nodes_[n].up || !nodes_[n].dirty) continue;
    reconcile(n);
    any = true;
  }
  return any;
}

bool NegotiationWorld::connect_all() {
  bool any = false;
  while (connect_by_daemon(false)) any = true;
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    if (!nodes_[n].up || !connections_changed(nodes_[n])) continue;
    look_after_connections(n);
    any = true;
  }
  return any;
}

bool NegotiationWorld::give_all() {
  bool any = false;
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    for (std::size_t i = 0; nodes_[n].up && i < nodes_[n].writers.size(); ++i) {
      const auto writer = std::next(nodes_[n].writers.begin(), static_cast<std::ptrdiff_t>(i));
      if (!owes_history(writer->second)) continue;
      give_history(n, i);
      any = true;
    }
  }
  return any;
}

void NegotiationWorld::check_agreement() {
  std::size_t endpoints = 0;
  for (const Node& node : nodes_) endpoints += node.up ? node.writers.size() + node.readers.size() : 0;
  for (const Node& there : nodes_) {
    if (!there.up) continue;
    if (there.negotiation.table().size() != endpoints)
      fail("endpoints are known that are gone, or are not known");
    for (const auto& [id, writer] : there.writers) {
      for (const Node& here : nodes_) {
        if (!here.up) continue;
        for (const auto& [reader_id, reader] : here.readers) check_pair(there, writer, here, reader);
      }
    }
  }
}

/// Both sides of a pair at rest: by the best path that both have, under exactly what the reader asks for, or
/// not at all if their policies do not fit. The history was given where it can be.
void NegotiationWorld::check_pair(const Node& there, const Writer& writer, const Node& here,
                                  const Reader& reader) {
  const Endpoint& w = writer.endpoint;
  const Endpoint& r = reader.endpoint;
  const bool memory =
      w.may_use_shm && r.may_use_shm && there.self.host.known() && there.self.host == here.self.host;
  const bool network = w.may_use_udp && r.may_use_udp;
  const bool matches = fits(w.qos, r.qos);
  const bool shm = matches && memory;
  const bool udp = matches && !memory && network;
  const Route* by_shm = route_to(writer.in_force.memory, r.id);
  const Route* by_udp = route_to(writer.in_force.network, r.id);
  if ((by_shm != nullptr) != shm || (by_udp != nullptr) != udp) fail("at rest, but not by the best path");
  const Route* route = by_shm != nullptr ? by_shm : by_udp;
  if (route != nullptr && !(route->mask == asked_.at(r.id).back().mask))
    fail("at rest, but under another mask");
  if (route != nullptr && route->min_period_us != asked_.at(r.id).back().request.min_period_us)
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

}  // namespace sft::test
