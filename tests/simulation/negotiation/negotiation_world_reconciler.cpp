// The reconciler of each node, and the daemon, as far as the world has them.
#include <utility>

#include "tests/simulation/negotiation/negotiation_world.h"
#include "tests/unit/core/control/endpoint_ids.h"

namespace sft::test {

using core::Request;

/// Notes that a node has work for its agent. What the negotiation wants is checked at once.
void NegotiationWorld::changed(std::size_t n, bool dirty) {
  Node& node = nodes_[n];
  node.dirty |= dirty;
  for (auto& [id, writer] : node.writers) {
    writer.wanted = node.negotiation.serving(id);
    check_serving(node, writer);
    if (!node.dirty && !(writer.wanted == writer.in_force)) fail("something changed, but it was not said");
  }
}

void NegotiationWorld::reconcile(std::size_t n) {
  Node& node = nodes_[n];
  node.dirty = false;
  for (auto& [id, writer] : node.writers) {
    writer.port |= writer.wanted.memory_port;
    writer.in_force = writer.wanted;
  }
  for (auto& [id, reader] : node.readers) reconcile_reader(n, id, reader);
}

void NegotiationWorld::reconcile_reader(std::size_t n, Id id, Reader& reader) {
  core::Negotiation& negotiation = nodes_[n].negotiation;
  std::map<Id, Heard> heard;
  for (const core::Hearing& hearing : negotiation.hearing(id)) {
    const Id writer = hearing.source.writer;
    heard[writer] = {hearing.network, hearing.memory};
    if (hearing.network) insert(reader.connected, writer);
    if (hearing.memory) insert(reader.subscribed, writer);
    if (hearing.memory) continue;
    std::erase(reader.subscribed, writer);
    std::erase(reader.fed, writer);
  }
  bool dirty = false;
  for (const auto& [writer, before] : reader.heard) {
    if (heard.contains(writer)) continue;
    if (std::erase(reader.connected, writer) != 0) insert(reader.let_go, writer);
    std::erase(reader.subscribed, writer);
    std::erase(reader.fed, writer);
    dirty |= negotiation.connection_changed(id, writer, TransportKind::udp, false);
    dirty |= negotiation.connection_changed(id, writer, TransportKind::shm, false);
  }
  reader.heard = std::move(heard);
  if (!dirty) return;
  note_request(negotiation, id);
  changed(n, dirty);
  send_request(n, id);
}

bool NegotiationWorld::connections_changed(const Node& node) const {
  for (const auto& [id, reader] : node.readers) {
    const Request& request = node.negotiation.local(id)->request;
    for (const auto& [writer, heard] : reader.heard) {
      if ((heard.network && holds(reader.connected, writer)) != holds(request.listening, writer)) return true;
      if ((heard.memory && holds(reader.fed, writer)) != holds(request.attached, writer)) return true;
      if (holds(request.begun, writer) && !holds(reader.history_came, writer)) return true;
    }
  }
  return false;
}

void NegotiationWorld::look_after_connections(std::size_t n) {
  core::Negotiation& negotiation = nodes_[n].negotiation;
  for (auto& [id, reader] : nodes_[n].readers) {
    bool dirty = false;
    bool came = false;
    for (const auto& [writer, heard] : reader.heard) {
      const bool listening = heard.network && holds(reader.connected, writer);
      const bool attached = heard.memory && holds(reader.fed, writer);
      dirty |= negotiation.connection_changed(id, writer, TransportKind::udp, listening);
      dirty |= negotiation.connection_changed(id, writer, TransportKind::shm, attached);
      if (!holds(negotiation.local(id)->request.begun, writer)) {
        std::erase(reader.history_came, writer);
      } else if (!holds(reader.history_came, writer)) {
        reader.history_came.push_back(writer);
        came |= negotiation.history_came(id, writer);
      }
    }
    if (dirty) note_request(negotiation, id);
    changed(n, dirty || came);
    if (dirty) send_request(n, id);
  }
}

/// The daemon connects the first subscriber that waits with its writer's port.
bool NegotiationWorld::connect_by_daemon(bool pretend) {
  for (Node& there : nodes_) {
    if (!there.up) continue;
    for (const auto& [id, writer] : there.writers) {
      if (!writer.port) continue;
      for (Node& here : nodes_) {
        if (!here.up || here.self.host != there.self.host) continue;
        for (auto& [reader_id, reader] : here.readers) {
          if (!holds(reader.subscribed, id) || holds(reader.fed, id)) continue;
          if (!pretend) reader.fed.push_back(id);
          return true;
        }
      }
    }
  }
  return false;
}

}  // namespace sft::test
