// Brings the world to rest: no new events happen, and all messages under way arrive.
#include "tests/simulation/negotiation/negotiation_laws.h"
#include "tests/simulation/negotiation/negotiation_world.h"

namespace sft::test {

/// Makes all steps that are still due, for all nodes.
class NegotiationWorld::Settling {
 public:
  explicit Settling(NegotiationWorld& world) : world_(world) {}

  void find_all_that_are_up() {
    for (const auto& [from, to] : world_.state_.channels.ends()) {
      if (world_.state_.nodes[from].up && !world_.state_.channels.between(from, to).found)
        world_.state_.find(from, to);
      if (world_.state_.nodes[from].up) continue;
      if (world_.state_.channels.between(from, to).found) world_.lose(from, to);
    }
    deliver_all();
    for (std::size_t n = 0; n < world_.state_.nodes.size(); ++n) {
      if (world_.state_.nodes[n].up) world_.forget(n);
    }
  }

  bool deliver_all() {
    bool any = false;
    for (const auto& [from, to] : world_.state_.channels.ends()) {
      for (const Word& word : world_.state_.channels.take_all(from, to)) world_.deliver(to, word);
    }
    for (std::size_t n = 0; n < world_.state_.nodes.size(); ++n) {
      if (!world_.state_.nodes[n].up || !world_.state_.nodes[n].dirty) continue;
      world_.reconcile(n);
      any = true;
    }
    return any;
  }

  bool connect_all() {
    bool any = false;
    while (world_.connect_by_daemon()) any = true;
    for (std::size_t n = 0; n < world_.state_.nodes.size(); ++n) {
      if (!world_.state_.nodes[n].up || !world_.state_.nodes[n].connections_changed()) continue;
      world_.look_after_connections(n);
      any = true;
    }
    return any;
  }

  bool give_all() {
    bool any = false;
    for (std::size_t n = 0; n < world_.state_.nodes.size(); ++n) {
      for (std::size_t i = 0; world_.state_.nodes[n].up && i < world_.state_.nodes[n].writers.size(); ++i) {
        if (!nth(world_.state_.nodes[n].writers, i).second.owes_history()) continue;
        world_.give_history(n, i);
        any = true;
      }
    }
    return any;
  }

 private:
  NegotiationWorld& world_;
};

void NegotiationWorld::settle() {
  Settling settling(*this);
  settling.find_all_that_are_up();
  for (int round = 0; violation_.empty(); ++round) {
    if (round == 100) return fail("it does not come to rest");
    const bool delivered = settling.deliver_all();
    const bool connected = settling.connect_all();
    const bool given = settling.give_all();
    if (!delivered && !connected && !given) break;
  }
  if (violation_.empty()) NegotiationLaws(state_.asked, violation_).check_agreement(state_.nodes);
}

}  // namespace sft::test
