// Answers to other nodes that ask for the accounts of our endpoints: which endpoints they ask about, and
// which accounts the next sign of life tells. Pure.
#pragma once

#include <chrono>
#include <map>
#include <set>
#include <vector>

#include "core/control/control.h"
#include "core/platform/clock.h"
#include "core/platform/turns.h"

namespace sft::core {

class AccountAnswers {
 public:
  /// `asks_last`: a node that does not ask again within that time has lost interest.
  explicit AccountAnswers(std::chrono::milliseconds asks_last) : asks_last_(asks_last) {}

  /// Somebody asks about one of our endpoints.
  void asked(EndpointId ours, Time now) { until_[ours] = now + asks_last_; }
  void removed(EndpointId ours) { until_.erase(ours); }
  /// The endpoints about which somebody has asked lately.
  std::vector<EndpointId> asked_about(Time now);

  /// The accounts that the next sign of life tells: as many of `all` as there is room for, in turns.
  std::vector<AccountId> take_turns(const std::set<AccountId>& all);

 private:
  const std::chrono::milliseconds asks_last_;
  std::map<EndpointId, Time> until_;
  Turns<AccountId> turns_;
};

}  // namespace sft::core
