#include "tests/simulation/negotiation/negotiation_state.h"

#include <algorithm>

#include "tests/unit/core/control/endpoint_ids.h"

namespace sft::test {

core::HostToken host_token(std::uint8_t n) {
  core::HostToken token;
  token.bytes.fill(n);
  return token;
}

void AskedRequests::note(const core::Request& request, const Selection& wanted) {
  asked_[request.reader].resize(request.sequence + 1,
                                std::make_shared<const Asked>(Asked{request, type_->closed(wanted)}));
}

bool AskedRequests::has_ever_asked_for(Id reader, const Selection& selection) const {
  return std::ranges::any_of(asked_.at(reader),
                             [&](const auto& asked) { return asked->selection == selection; });
}

bool WorldWriter::owes_history() const {
  const auto is_late = [](const core::Route& route) { return route.history != 0; };
  return std::ranges::any_of(in_force.memory, is_late) ||
         std::ranges::any_of(in_force.network, [&](const core::Route& route) {
           return is_late(route) && !history_given.contains(route.reader);
         });
}

bool WorldNode::has_begun(Id writer, Id reader, const AskedRequests& asked) const {
  if (const auto own = readers.find(reader); own != readers.end())
    return holds(negotiation.local(reader)->request.begun, writer);
  const auto known = reported.find(reader);
  if (known == reported.end()) return false;
  return holds(asked.at(reader, known->second.newest).request.begun, writer);
}

void WorldNode::owe_what_has_not_begun(Id reader, const AskedRequests& asked) {
  for (auto& [writer_id, writer] : writers) {
    if (!has_begun(writer_id, reader, asked)) writer.history_given.erase(reader);
  }
}

void WorldNode::forget_history(Id reader) {
  for (auto& [writer_id, writer] : writers) writer.history_given.erase(reader);
}

bool WorldNode::connections_changed() const {
  for (const auto& [reader_id, reader] : readers) {
    const core::Request& request = negotiation.local(reader_id)->request;
    for (const auto& [writer, heard] : reader.heard) {
      if ((heard.network && holds(reader.connected, writer)) != holds(request.listening, writer)) return true;
      if ((heard.memory && holds(reader.fed, writer)) != holds(request.attached, writer)) return true;
      if (holds(request.begun, writer) && !holds(reader.history_came, writer)) return true;
    }
  }
  return false;
}

void NegotiationState::find(std::size_t from, std::size_t to) {
  channels.find(from, to, nodes[from].sent, nodes[from].announced);
}

void NegotiationState::publish(std::size_t node, std::size_t writer) {
  const auto& [id, publisher] = nth(nodes[node].writers, writer);
  for (const core::Route& route : publisher.in_force.network)
    datagrams.push_back({id, route.reader, route.selection});
}

Datagram NegotiationState::take_datagram(std::size_t which) {
  Datagram taken = datagrams[which];
  datagrams.erase(datagrams.begin() + static_cast<std::ptrdiff_t>(which));
  return taken;
}

std::optional<Unconnected> unconnected(const std::vector<WorldNode>& nodes) {
  for (const WorldNode& there : nodes) {
    if (!there.up) continue;
    for (const auto& [id, writer] : there.writers) {
      if (!writer.port) continue;
      for (std::size_t n = 0; n < nodes.size(); ++n) {
        if (!nodes[n].up || nodes[n].self.host != there.self.host) continue;
        for (const auto& [reader_id, reader] : nodes[n].readers) {
          if (holds(reader.subscribed, id) && !holds(reader.fed, id)) return Unconnected{n, reader_id, id};
        }
      }
    }
  }
  return std::nullopt;
}

}  // namespace sft::test
