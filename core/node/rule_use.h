// Remembers which remapping rules of the nodes of this process have fitted something. A rule is often meant
// for one of several nodes. So only a rule that has fitted nothing in any of them is told to the user, once,
// by one of them.
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
  /// Within this time after its last node has opened, a program has opened its first publishers and
  /// subscribers.
  static constexpr std::chrono::seconds time_to_open{5};

  /// The one that all nodes of the process share. It lives as long as one of them has it.
  static std::shared_ptr<RuleUse> of_process();

  using Rules = std::vector<std::string>;
  // Any thread.

  /// A node has opened, with these rules.
  void enter(const Rules& rules, Time now);
  /// These rules have fitted something.
  void fit(const Rules& rules);
  /// Returns those that have fitted nothing yet, each once; none before the time is over.
  Rules take_unfit(Time now);
  /// A node closes. Returns what take_unfit() would, whatever the time, if this was the last node.
  Rules leave();

 private:
  Rules take_unfit() SFT_REQUIRES(mutex_);

  Mutex mutex_;
  std::size_t nodes_ SFT_GUARDED_BY(mutex_) = 0;
  Time opened_ SFT_GUARDED_BY(mutex_){};                        ///< the last node
  std::map<std::string, bool> is_done_ SFT_GUARDED_BY(mutex_);  ///< true: it has fitted, or was told
};

}  // namespace sft::core
