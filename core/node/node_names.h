// Applies the remapping rules of one node to its topics, and finds the rules that have matched no name. A
// rule is often meant for only one of several nodes. So a rule is reported to the user only if it has matched
// no name of any node of the process. Only one of the nodes reports the rule, and only once.
#pragma once

#include <chrono>
#include <cstddef>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/names/remapping.h"
#include "core/platform/clock.h"
#include "core/sync/mutex.h"

namespace sft::core {

/// The rules of all nodes of the process, and which of them have matched a name.
class RuleUse {
 public:
  /// The time that a program is given, after it has opened its last node, to open its first publishers and
  /// subscribers.
  static constexpr std::chrono::seconds time_to_open{5};

  /// Returns the object that all nodes of the process share. The object lives as long as one of the nodes
  /// holds it.
  static std::shared_ptr<RuleUse> of_process();

  using Rules = std::vector<std::string>;
  // The functions for any thread.

  /// Notes that a node with these rules has opened.
  void enter(const Rules& rules, Time now);
  /// Notes that these rules have matched a name.
  void fit(const Rules& rules);
  /// Returns the rules that have matched no name so far, each rule once. Returns no rules before
  /// `time_to_open` is over.
  Rules take_unfit(Time now);
  /// Called when a node closes. If it was the last node, returns the rules that take_unfit() would return,
  /// but without waiting for `time_to_open`.
  Rules leave();

 private:
  Rules take_unfit() SFT_REQUIRES(mutex_);

  Mutex mutex_;
  std::size_t nodes_ SFT_GUARDED_BY(mutex_) = 0;
  Time opened_ SFT_GUARDED_BY(mutex_){};  ///< the time when the last node was opened
  /// For the text of each rule, true if the rule has matched a name or was reported.
  std::map<std::string, bool> is_done_ SFT_GUARDED_BY(mutex_);
};

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
