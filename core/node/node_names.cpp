#include "core/node/node_names.h"

#include <utility>

namespace sft::core {

std::shared_ptr<RuleUse> RuleUse::of_process() {
  static Mutex mutex;
  static std::weak_ptr<RuleUse> current SFT_GUARDED_BY(mutex);
  const Lock lock(mutex);
  std::shared_ptr<RuleUse> use = current.lock();
  if (use == nullptr) current = use = std::make_shared<RuleUse>();
  return use;
}

void RuleUse::enter(const Rules& rules, Time now) {
  const Lock lock(mutex_);
  ++nodes_;
  opened_ = now;
  for (const std::string& rule : rules) is_done_.try_emplace(rule, false);
}

void RuleUse::fit(const Rules& rules) {
  const Lock lock(mutex_);
  for (const std::string& rule : rules) is_done_[rule] = true;
}

RuleUse::Rules RuleUse::take_unfit(Time now) {
  const Lock lock(mutex_);
  return now - opened_ < time_to_open ? Rules() : take_unfit();
}

RuleUse::Rules RuleUse::leave() {
  const Lock lock(mutex_);
  return --nodes_ > 0 ? Rules() : take_unfit();
}

RuleUse::Rules RuleUse::take_unfit() {
  Rules unfit;
  for (auto& [rule, is_done] : is_done_) {
    if (!std::exchange(is_done, true)) unfit.push_back(rule);
  }
  return unfit;
}

}  // namespace sft::core
