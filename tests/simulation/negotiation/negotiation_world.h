// A few nodes whose negotiations talk to each other, in one thread and without time: what the control
// channel, the transports and the reconciler do is modelled, one step at a time, so that a test may choose
// the next step as it likes. After each step the world knows whether something is wrong.
//
// Discovery keeps the last of each endpoint: what was overwritten before it came may or may not come, and
// what came last may come twice. What is said of one endpoint comes in order. A node may lose another and
// find it again, which brings all again that the other has to say. Nodes may be killed and come back under
// new ids.
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

  /// `type` outlives the world. `random` chooses what a step leaves open; without, the first possibility.
  NegotiationWorld(const Plan& plan, const TypeSupport& type, Random* random = nullptr);

  /// All that may happen next.
  const std::vector<Step>& steps();
  void take(const Step& step);
  /// All nodes find each other again, nothing else happens any more, and what is under way comes; then checks
  /// that both sides of each pair agree, and that every reader is served under exactly what it asks for.
  void settle();
  /// Empty while all is well.
  const std::string& violation() const { return violation_; }
  /// The steps so far.
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
