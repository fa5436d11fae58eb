#include "tests/simulation/negotiation/negotiation_steps.h"

#include <algorithm>

namespace sft::test {

namespace {

using What = NegotiationStep::What;

class StepList {
 public:
  StepList(const NegotiationState& state, std::vector<NegotiationStep>& steps)
      : state_(state), steps_(steps) {}

  void add(What what, std::size_t node, std::size_t other = 0) {
    steps_.push_back({what, static_cast<std::uint8_t>(node), static_cast<std::uint8_t>(other)});
  }
  void of_pair(std::size_t from, std::size_t to) {
    const ControlChannel& c = state_.channels.between(from, to);
    if (!c.words.empty()) add(What::word_comes, to, from);
    if (state_.left.repetitions > 0 && c.last.id != 0) add(What::word_repeated, to, from);
    if (c.found && (state_.left.losses > 0 || !state_.nodes[from].up)) add(What::node_lost, to, from);
    if (!c.found && state_.nodes[from].up) add(What::node_found, to, from);
  }
  void of_node(std::size_t n) {
    const WorldNode& node = state_.nodes[n];
    if (node.dirty) add(What::agent_reconciles, n);
    if (node.connections_changed()) add(What::agent_looks_after_connections, n);
    const auto is_lost = [](const auto& reported) { return reported.second.lost_since.has_value(); };
    if (std::any_of(node.reported.begin(), node.reported.end(), is_lost)) add(What::lost_forgotten, n);
    for (std::size_t i = 0; i < node.readers.size() && state_.left.selection_changes > 0; ++i)
      add(What::selection_changes, n, i);
    for (std::size_t i = 0; i < node.readers.size() && state_.left.rate_changes > 0; ++i)
      add(What::rate_changes, n, i);
    for (std::uint8_t i = 0; i < 3 && state_.left.memory_changes > 0; ++i) {
      if (node.self.host != host_token(i)) add(What::memory_changes, n, i);
    }
    if (state_.left.restarts > 0) add(What::node_killed, n);
    const std::size_t endpoints = node.writers.size() + node.readers.size();
    for (std::size_t i = 0; i < endpoints && state_.left.departures > 0; ++i)
      add(What::endpoint_departs, n, i);
    for (std::size_t i = 0; i < node.writers.size() && state_.left.samples > 0; ++i)
      add(What::sample_published, n, i);
    for (std::size_t i = 0; i < node.writers.size(); ++i) {
      if (nth(node.writers, i).second.owes_history()) add(What::history_leaves, n, i);
    }
  }

 private:
  const NegotiationState& state_;
  std::vector<NegotiationStep>& steps_;
};

}  // namespace

void list_steps(const NegotiationState& state, std::vector<NegotiationStep>& steps) {
  steps.clear();
  StepList list(state, steps);
  for (const auto& [from, to] : state.channels.ends()) list.of_pair(from, to);
  std::uint64_t places_in_use = 0;
  for (std::size_t n = 0; n < state.nodes.size(); ++n) {
    if (!state.nodes[n].up) continue;
    places_in_use |= std::uint64_t{1} << state.nodes[n].place;
    list.of_node(n);
  }
  for (std::size_t place = 0; place < state.places; ++place) {
    if ((places_in_use >> place & 1) == 0) list.add(What::node_started, place);
  }
  if (unconnected(state.nodes)) list.add(What::daemon_connects, 0);
  for (std::size_t i = 0; i < state.datagrams.size(); ++i) {
    list.add(What::datagram_comes, 0, i);
    list.add(What::datagram_lost, 0, i);
  }
}

}  // namespace sft::test
