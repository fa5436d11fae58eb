// A few nodes whose negotiations exchange messages, in one thread and without time. The control channels,
// the transports and the reconcilers are modelled as single steps, and the test chooses the next step. After
// each step the world checks the laws.
//
// Discovery keeps the last message of each endpoint. A message that was overwritten before its arrival may
// arrive or not, and the last message may arrive twice. Messages about one endpoint arrive in order. A node
// may lose another node and find it again. Then all announcements of the found node arrive again. Nodes may
// be killed, and are started again with new ids.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/simulation/negotiation/negotiation_state.h"
#include "tests/simulation/negotiation/negotiation_steps.h"
#include "tests/support/test_seed.h"

namespace sft::test {

class NegotiationWorld {
 public:
  using Plan = NegotiationPlan;
  using EndpointPlan = NegotiationPlan::Endpoint;
  using Budget = NegotiationPlan::Budget;
  using Step = NegotiationStep;

  /// `type` outlives the world. `random` chooses where a step leaves a choice. If `random` is null, the first
  /// possibility is taken.
  NegotiationWorld(const Plan& plan, const TypeSupport& type, Random* random = nullptr);

  /// Returns all possible next steps.
  const std::vector<Step>& steps();
  void take(const Step& step);
  /// Makes all nodes find each other again, and all messages under way arrive. Then checks that both sides of
  /// each pair agree, and that every reader is served under exactly the selection that it requests.
  void settle();
  /// Returns the first violation of a law, or "" if there is none.
  const std::string& violation() const { return violation_; }
  /// Returns the steps so far as text.
  std::string history() const;

 private:
  struct StepKind;
  class Settling;
  static const std::array<StepKind, 18> step_kinds;

  void fail(const std::string& what);

  void start_node(std::size_t place);
  void kill(std::size_t node);
  void add_endpoint(WorldNode& node, const NegotiationPlan::Endpoint& plan);
  void depart(std::size_t node, std::size_t which);
  void change_selection(std::size_t node, std::size_t which);
  void change_rate(std::size_t node, std::size_t which);
  void change_memory(std::size_t node, const core::HostToken& host);
  void give_history(std::size_t node, std::size_t which);
  void history_comes(Id writer, Id reader, TransportKind path);

  void announce(std::size_t node, Id id);
  void send_request(std::size_t node, Id reader);
  void note_request(std::size_t node, Id reader);
  void deliver(std::size_t to, const Word& word);
  void seen(std::size_t to, const std::shared_ptr<const core::Endpoint>& endpoint);
  void requested(std::size_t to, const core::Request& request);
  void lose(std::size_t from, std::size_t to);
  void forget(std::size_t node);

  void reconcile(std::size_t node);
  void reconcile_reader(std::size_t node, Id id, WorldReader& reader);
  void look_after_connections(std::size_t node);
  bool connect_by_daemon();
  void changed(std::size_t node, bool dirty);

  const Plan plan_;
  const TypeSupport* type_;
  Random* random_;
  Id next_id_ = 1;
  NegotiationState state_;
  std::vector<Step> steps_;
  std::vector<Step> taken_;
  std::string violation_;
};

}  // namespace sft::test
