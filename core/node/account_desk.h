// Accounts of pairs of publishers and subscribers: what this node asks others about, what it answers them,
// and what it knows for its own program. The agent's.
#pragma once

#include <chrono>
#include <set>
#include <string>
#include <vector>

#include "core/negotiation/negotiation.h"
#include "core/node/account_answers.h"
#include "core/node/account_questions.h"
#include "core/node/local_endpoints.h"
#include "core/platform/clock.h"

namespace sft::core {

class AccountDesk {
 public:
  /// Both outlive this object.
  AccountDesk(const Negotiation& negotiation, const LocalEndpoints& ours)
      : negotiation_(negotiation), ours_(ours) {}

  /// The program wants to know the accounts of all pairs on that topic, until it has said as often that it
  /// does not any more.
  void ask(const std::string& topic) { questions_.ask(topic); }
  void ask_no_more(const std::string& topic) { questions_.ask_no_more(topic); }
  /// The accounts that are known of the pairs that the program asks about.
  PairAccounts known(Time now = std::chrono::steady_clock::now());

  /// Another node, or this one, has given a sign of life, which may ask and answer.
  void hear(const Assertion& sign, Time now);
  /// One of our endpoints was removed.
  void removed(EndpointId ours) { answers_.removed(ours); }
  /// Adds what our next sign of life asks and answers.
  void fill_in(Assertion& sign, Time now);

 private:
  /// A node that does not ask again within that time has lost interest.
  static constexpr std::chrono::milliseconds asks_last{3000};

  std::vector<EndpointId> questions();
  std::vector<Account> answers(Time now);
  void add_accounts_of(EndpointId own, std::set<AccountId>& accounts) const;
  Account account(const AccountId& id) const;

  const Negotiation& negotiation_;
  const LocalEndpoints& ours_;
  AccountQuestions questions_;
  AccountAnswers answers_{asks_last};
};

}  // namespace sft::core
