// Remembers which remapping rules of the nodes of this process have matched a name. A rule is often meant for
// one of several nodes. So the user is told of a rule only if it has matched nothing in any of them. One of
// the nodes does that, once.
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
  /// The time that a program needs, after it has opened its last node, to open its first publishers and
  /// subscribers.
  static constexpr std::chrono::seconds time_to_open{5};

  /// Returns the object that all nodes of the process share. It lives as long as one of them holds it.
  static std::shared_ptr<RuleUse> of_process();

  using Rules = std::vector<std::string>;
  // Any thread.

  /// Notes that a node with these rules has opened.
  void enter(const Rules& rules, Time now);
  /// Notes that these rules have matched a name.
  void fit(const Rules& rules);
  /// Returns the rules that have matched nothing so far, each once; none before `time_to_open` is over.
  Rules take_unfit(Time now);
  /// A node closes. If it was the last node, this returns what take_unfit() would return, whatever the time.
  Rules leave();

 private:
  Rules take_unfit() SFT_REQUIRES(mutex_);

  Mutex mutex_;
  std::size_t nodes_ SFT_GUARDED_BY(mutex_) = 0;
  Time opened_ SFT_GUARDED_BY(mutex_){};                        ///< when the last node opened
  std::map<std::string, bool> is_done_ SFT_GUARDED_BY(mutex_);  ///< by rule; true: matched or reported
};

}  // namespace sft::core
