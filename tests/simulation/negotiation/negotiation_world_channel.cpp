// The nodes of the world tell each other things here, and these arrive or get lost.
#include <algorithm>
#include <utility>

#include "tests/simulation/negotiation/negotiation_world.h"
#include "tests/unit/core/control/endpoint_ids.h"

namespace sft::test {

using core::Endpoint;
using core::Request;
using core::Role;

void NegotiationWorld::announce(std::size_t n, Id id) {
  auto endpoint = std::make_shared<const Endpoint>(*state_.nodes[n].negotiation.local(id));
  state_.nodes[n].announced[id] = endpoint;
  state_.channels.send(n, Announcement{id, endpoint});
}

void NegotiationWorld::send_request(std::size_t n, Id reader) {
  auto request = std::make_shared<const Request>(state_.nodes[n].negotiation.local(reader)->request);
  state_.nodes[n].sent[reader] = request;
  state_.channels.send(n, request);
}

void NegotiationWorld::note_request(std::size_t n, Id reader) {
  const WorldNode& node = state_.nodes[n];
  state_.asked.note(node.negotiation.local(reader)->request, node.readers.at(reader).wanted);
}

void NegotiationWorld::deliver(std::size_t to, const Announcement& announcement) {
  WorldNode& node = state_.nodes[to];
  if (announcement.endpoint == nullptr) {
    node.told.erase(announcement.id);
    node.forget_history(announcement.id);
    return changed(to, node.negotiation.endpoint_departed(announcement.id));
  }
  Told& told = node.told[announcement.id];
  told.newest = std::max({told.newest, told.newest_while_away, announcement.endpoint->request.sequence});
  told.newest_while_away = 0;
  told.endpoint = announcement.endpoint;
  told.lost_since.reset();
  if (told.endpoint->role == Role::reader) node.owe_what_has_not_begun(announcement.id, state_.asked);
  changed(to, node.negotiation.endpoint_seen(*announcement.endpoint));
}

void NegotiationWorld::deliver(std::size_t to, const Request& request) {
  WorldNode& node = state_.nodes[to];
  Told& told = node.told[request.reader];
  const bool here = told.endpoint != nullptr && !told.lost();
  std::uint64_t& newest = here ? told.newest : told.newest_while_away;
  newest = std::max(newest, request.sequence);
  if (here) node.owe_what_has_not_begun(request.reader, state_.asked);
  changed(to, node.negotiation.request_received(request));
}

void NegotiationWorld::lose(std::size_t from, std::size_t to) {
  state_.channels.lose(from, to);
  WorldNode& node = state_.nodes[to];
  bool dirty = false;
  for (auto& [id, told] : node.told) {
    if (told.endpoint == nullptr || !holds(state_.nodes[from].opened, id)) continue;
    if (!told.lost_since) told.lost_since = node.now;
    dirty |= node.negotiation.endpoint_lost(id, node.now);
  }
  changed(to, dirty);
}

void NegotiationWorld::forget(std::size_t n) {
  WorldNode& node = state_.nodes[n];
  node.now += std::chrono::seconds(60);
  for (auto& [id, told] : node.told) {
    if (!told.lost_since) continue;
    told = {.endpoint = nullptr, .lost_since = {}, .newest = 0, .newest_while_away = told.newest_while_away};
    node.forget_history(id);
  }
  changed(n, node.negotiation.tick(node.now));
}

}  // namespace sft::test
