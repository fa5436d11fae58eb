// Of which of our endpoints others want to know what was counted, and which of these accounts the next sign
// of life tells them. Pure.
#pragma once

#include <chrono>
#include <map>
#include <set>
#include <vector>

#include "core/control/control.h"
#include "core/platform/turns.h"

namespace sft::core {

class AccountAnswers {
 public:
  using Now = std::chrono::steady_clock::time_point;

  /// `asks_last`: whoever does not ask again within that time has lost interest.
  explicit AccountAnswers(std::chrono::milliseconds asks_last) : asks_last_(asks_last) {}

  /// Somebody asks about one of our endpoints.
  void asked(EndpointId ours, Now now) { until_[ours] = now + asks_last_; }
  void removed(EndpointId ours) { until_.erase(ours); }
  /// Those about which somebody has asked lately.
  std::vector<EndpointId> asked_about(Now now);

  /// Those accounts of `all` that the next sign of life tells: no more than it has room for, in turns.
  std::vector<AccountId> take_turns(const std::set<AccountId>& all);

 private:
  const std::chrono::milliseconds asks_last_;
  std::map<EndpointId, Now> until_;
  Turns<AccountId> turns_;
};

}  // namespace sft::core
