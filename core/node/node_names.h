// Applies the remapping rules of one node to its topics, and returns the rules that have matched no name.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/control/remapping.h"
#include "core/node/rule_use.h"
#include "core/platform/clock.h"

namespace sft::core {

class NodeNames {
 public:
  explicit NodeNames(Remapping remapping, Time now = std::chrono::steady_clock::now())
      : remapping_(std::move(remapping)) {
    if (remapping_.rules().empty()) return;
    use_ = RuleUse::of_process();
    use_->enter(remapping_.rules(), now);
    use_->fit(remapping_.rules_of_node());
  }
  ~NodeNames() { leave(); }
  NodeNames(const NodeNames&) = delete;
  NodeNames& operator=(const NodeNames&) = delete;

  /// Returns the resolved name of a topic. Any thread may call this.
  Result<TopicName> topic(std::string_view given, std::string_view type = {}) const {
    Result<TopicName> name = remapping_.topic(given, type);
    if (name && !name->rules.empty()) use_->fit(name->rules);
    return name;
  }
  /// Returns the rules that have to be reported as unused now; see RuleUse. Called by the agent, and by the
  /// thread that destroys the node after the agent has ended.
  std::vector<std::string> take_unfit_rules(Time now) const {
    return use_ == nullptr ? std::vector<std::string>() : use_->take_unfit(now);
  }
  /// Called when the node closes. Returns the rules that still have to be reported as unused. topic() must
  /// not be called after that.
  std::vector<std::string> leave() {
    const std::shared_ptr<RuleUse> use = std::exchange(use_, nullptr);
    return use == nullptr ? std::vector<std::string>() : use->leave();
  }

 private:
  const Remapping remapping_;
  std::shared_ptr<RuleUse> use_;  ///< null: there are no rules, or leave() was called
};

}  // namespace sft::core
