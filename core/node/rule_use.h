// Records which remapping rules of the nodes of this process have matched a name. A rule is often meant for
// only one of several nodes. So a rule is reported to the user only if it has matched no name of any node.
// Only one of the nodes reports the rule, and only once.
#pragma once

#include <chrono>
#include <cstddef>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/platform/clock.h"
#include "core/sync/mutex.h"

namespace sft::core {

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

}  // namespace sft::core
