#include "core/node/account_desk.h"

namespace sft::core {

void AccountDesk::hear(const Assertion& sign, Time now) {
  for (const EndpointId id : sign.asked_about) {
    if (ours_.contains(id)) answers_.asked(id, now);
  }
  questions_.answered(
      sign, [this](EndpointId id) { return negotiation_.table().known(id); }, now);
}

void AccountDesk::fill_in(Assertion& sign, Time now) {
  sign.asked_about = questions();
  sign.accounts = answers(now);
}

/// The endpoints of others on the topics that the program asks about.
std::vector<EndpointId> AccountDesk::questions() {
  if (!questions_.asks()) return {};
  std::set<EndpointId> others;
  for (const Endpoint* endpoint : negotiation_.table().present()) {
    if (!ours_.contains(endpoint->id) && questions_.asks_about(endpoint->topic)) others.insert(endpoint->id);
  }
  return questions_.take_turns(others);
}

std::vector<Account> AccountDesk::answers(Time now) {
  std::set<AccountId> all;
  for (const EndpointId own : answers_.asked_about(now)) add_accounts_of(own, all);
  std::vector<Account> accounts;
  for (const AccountId& id : answers_.take_turns(all)) accounts.push_back(account(id));
  return accounts;
}

/// Adds the pairs that one of our endpoints matches: of other pairs there is nothing to count.
void AccountDesk::add_accounts_of(EndpointId own, std::set<AccountId>& accounts) const {
  if (const auto writer = ours_.writers.find(own); writer != ours_.writers.end()) {
    for (const EndpointId reader : writer->second.matching_readers())
      accounts.insert({{own, reader}, Role::writer});
  }
  if (const auto reader = ours_.readers.find(own); reader != ours_.readers.end()) {
    for (const EndpointId writer : reader->second.matching_writers())
      accounts.insert({{writer, own}, Role::reader});
  }
}

/// `id` is one that add_accounts_of() has added.
Account AccountDesk::account(const AccountId& id) const {
  Account account{.id = id};
  if (id.said_by == Role::reader) {
    account.by_reader = ours_.readers.at(id.pair.reader).ports().account_of(id.pair.writer);
  } else {
    account.by_writer = ours_.writers.at(id.pair.writer).account_of(id.pair.reader);
  }
  return account;
}

/// Joins the accounts that others have told with the present accounts of our own endpoints.
PairAccounts AccountDesk::known(Time now) {
  PairAccounts known = questions_.answers(now);
  std::set<AccountId> ours;
  const auto look_at = [&](const auto& endpoints) {
    for (const auto& [id, endpoint] : endpoints) {
      if (questions_.asks_about(endpoint.core().spec().topic)) add_accounts_of(id, ours);
    }
  };
  look_at(ours_.writers);
  look_at(ours_.readers);
  for (const AccountId& id : ours) add_to(known, account(id), {});
  return known;
}

}  // namespace sft::core
