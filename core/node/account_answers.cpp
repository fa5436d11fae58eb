#include "core/node/account_answers.h"

namespace sft::core {

std::vector<EndpointId> AccountAnswers::asked_about(Time now) {
  std::erase_if(until_, [&](const auto& ask) { return now >= ask.second; });
  std::vector<EndpointId> ids;
  for (const auto& [id, until] : until_) ids.push_back(id);
  return ids;
}

std::vector<AccountId> AccountAnswers::take_turns(const std::set<AccountId>& all) {
  std::vector<AccountId> next;
  turns_.go_round(all, accounts_max, [&](const AccountId& id) {
    next.push_back(id);
    return true;
  });
  return next;
}

}  // namespace sft::core
