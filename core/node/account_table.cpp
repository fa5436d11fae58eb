#include "core/node/account_table.h"

namespace sft::core {

void AccountTable::enter(const Account& account, Time now) {
  if (entries_.size() < accounts_max || entries_.contains(account.id))
    entries_.insert_or_assign(account.id, Entry{account, now});
}

PairAccounts AccountTable::accounts(Time now) {
  std::erase_if(entries_, [&](const auto& item) { return now - item.second.at >= kept_for; });
  PairAccounts accounts;
  for (const auto& [id, entry] : entries_) add_to(accounts, entry.account, now - entry.at);
  return accounts;
}

void add_to(PairAccounts& accounts, const Account& account, std::chrono::nanoseconds age) {
  DomainSnapshot::Account& pair = accounts[account.id.pair];
  if (account.id.said_by == Role::writer) {
    pair.publisher = account.by_writer;
    pair.publisher->age = age;
  } else {
    pair.subscriber = account.by_reader;
    pair.subscriber->age = age;
  }
}

}  // namespace sft::core
