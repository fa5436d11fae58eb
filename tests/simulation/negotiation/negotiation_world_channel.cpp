// The messages between the nodes of the world: sending, arrival and loss.
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
  state_.channels.send(n, {.id = id, .endpoint = endpoint});
}

void NegotiationWorld::send_request(std::size_t n, Id reader) {
  auto request = std::make_shared<const Request>(state_.nodes[n].negotiation.local(reader)->request);
  state_.nodes[n].sent[reader] = request;
  state_.channels.send(n, {.id = reader, .request = request});
}

void NegotiationWorld::note_request(std::size_t n, Id reader) {
  const WorldNode& node = state_.nodes[n];
  state_.asked.note(node.negotiation.local(reader)->request, node.readers.at(reader).wanted);
}

void NegotiationWorld::deliver(std::size_t to, const Word& word) {
  if (word.endpoint != nullptr) return seen(to, word.endpoint);
  if (word.request != nullptr) return requested(to, *word.request);
  WorldNode& node = state_.nodes[to];
  node.reported.erase(word.id);
  node.forget_history(word.id);
  changed(to, node.negotiation.endpoint_departed(word.id));
}

void NegotiationWorld::seen(std::size_t to, const std::shared_ptr<const Endpoint>& endpoint) {
  WorldNode& node = state_.nodes[to];
  node.reported[endpoint->id] = {
      .endpoint = endpoint, .lost_since = {}, .newest = endpoint->request.sequence};
  if (endpoint->role == Role::reader) node.owe_what_has_not_begun(endpoint->id, state_.asked);
  changed(to, node.negotiation.endpoint_seen(*endpoint));
}

void NegotiationWorld::requested(std::size_t to, const Request& request) {
  WorldNode& node = state_.nodes[to];
  const auto reported = node.reported.find(request.reader);
  if (reported != node.reported.end() && !reported->second.lost()) {
    reported->second.newest = request.sequence;
    node.owe_what_has_not_begun(request.reader, state_.asked);
  }
  changed(to, node.negotiation.request_received(request));
}

void NegotiationWorld::lose(std::size_t from, std::size_t to) {
  state_.channels.lose(from, to);
  WorldNode& node = state_.nodes[to];
  bool dirty = false;
  for (auto& [id, reported] : node.reported) {
    if (!holds(state_.nodes[from].opened, id)) continue;
    if (!reported.lost_since) reported.lost_since = node.now;
    dirty |= node.negotiation.endpoint_lost(id, node.now);
  }
  changed(to, dirty);
}

void NegotiationWorld::forget(std::size_t n) {
  WorldNode& node = state_.nodes[n];
  node.now += std::chrono::seconds(60);
  std::erase_if(node.reported, [&](const auto& item) {
    if (item.second.lost()) node.forget_history(item.first);
    return item.second.lost();
  });
  changed(n, node.negotiation.tick(node.now));
}

}  // namespace sft::test
