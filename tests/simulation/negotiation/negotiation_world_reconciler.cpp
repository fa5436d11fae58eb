// The world's models of the reconciler of each node, and of the daemon.
#include <utility>

#include "tests/simulation/negotiation/negotiation_laws.h"
#include "tests/simulation/negotiation/negotiation_world.h"
#include "tests/unit/core/control/endpoint_ids.h"

namespace sft::test {

/// Records if the node has work for its agent, and checks at once the result that the negotiation wants.
void NegotiationWorld::changed(std::size_t n, bool dirty) {
  WorldNode& node = state_.nodes[n];
  node.dirty |= dirty;
  for (auto& [id, writer] : node.writers) {
    writer.wanted = node.negotiation.serving(id);
    NegotiationLaws(state_.asked, violation_).check_serving(node, writer);
    if (!node.dirty && !(writer.wanted == writer.in_force)) fail("something changed, but it was not said");
  }
}

void NegotiationWorld::reconcile(std::size_t n) {
  WorldNode& node = state_.nodes[n];
  node.dirty = false;
  for (auto& [id, writer] : node.writers) {
    writer.port |= writer.wanted.memory_port;
    writer.in_force = writer.wanted;
  }
  for (auto& [id, reader] : node.readers) reconcile_reader(n, id, reader);
}

void NegotiationWorld::reconcile_reader(std::size_t n, Id id, WorldReader& reader) {
  core::Negotiation& negotiation = state_.nodes[n].negotiation;
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
    dirty |= negotiation.connection_changed(id, writer, false, false);
  }
  reader.heard = std::move(heard);
  if (!dirty) return;
  note_request(n, id);
  changed(n, dirty);
  send_request(n, id);
}

void NegotiationWorld::look_after_connections(std::size_t n) {
  core::Negotiation& negotiation = state_.nodes[n].negotiation;
  for (auto& [id, reader] : state_.nodes[n].readers) {
    bool dirty = false;
    bool came = false;
    for (const auto& [writer, heard] : reader.heard) {
      const bool listening = heard.network && holds(reader.connected, writer);
      const bool attached = heard.memory && holds(reader.fed, writer);
      dirty |= negotiation.connection_changed(id, writer, listening, attached);
      if (!holds(negotiation.local(id)->request.begun, writer)) {
        std::erase(reader.history_came, writer);
      } else if (!holds(reader.history_came, writer)) {
        reader.history_came.push_back(writer);
        came |= negotiation.history_came(id, writer);
      }
    }
    if (dirty) note_request(n, id);
    changed(n, dirty || came);
    if (dirty) send_request(n, id);
  }
}

/// Connects the first waiting reader with its writer's port. Returns false if no reader waits.
bool NegotiationWorld::connect_by_daemon() {
  const auto found = unconnected(state_.nodes);
  if (found) state_.nodes[found->node].readers.at(found->reader).fed.push_back(found->writer);
  return found.has_value();
}

}  // namespace sft::test
