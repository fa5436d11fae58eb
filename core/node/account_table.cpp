#include "core/node/account_table.h"

#include <iterator>

namespace sft::core {

/// The number of accounts per topic is not limited, because the table has only accounts of topics that the
/// program asks about.
AccountTable::AccountTable(const Limits& limits)
    : limits_(limits),
      shares_({.entries = limits.accounts,
               .of_announcer = limits.of_announcer,
               .topic_shares_from = limits.accounts,
               .of_topic = limits.accounts}) {}

void AccountTable::enter(const Account& account, AnnouncerId by, Time now) {
  const auto before = entries_.find(account.id);
  if (before != entries_.end() && before->second.by == by) {
    before->second.account = account;
    before->second.at = now;
    return;
  }
  if (before != entries_.end()) erase(before);
  const TableShares::Admission admission = shares_.admit(by, {});
  if (!admission.granted) return;
  if (admission.instead_of) erase(entries_.find(numbers_.at(*admission.instead_of)));
  const std::uint64_t number = ++numbered_;
  shares_.enter(number, by, {});
  numbers_.emplace(number, account.id);
  entries_.emplace(account.id, Entry{account, by, number, now});
}

void AccountTable::erase(Entries::iterator entry) {
  shares_.remove(entry->second.number);
  numbers_.erase(entry->second.number);
  entries_.erase(entry);
}

void AccountTable::clear() {
  while (!entries_.empty()) erase(entries_.begin());
}

PairAccounts AccountTable::accounts(Time now) {
  PairAccounts accounts;
  for (auto entry = entries_.begin(); entry != entries_.end();) {
    const auto next = std::next(entry);
    const Time::duration age = now - entry->second.at;
    age >= limits_.kept_for ? erase(entry) : add_to(accounts, entry->second.account, age);
    entry = next;
  }
  return accounts;
}

void add_to(PairAccounts& accounts, const Account& account, std::chrono::nanoseconds age) {
  DomainSnapshot::Account& pair = accounts[account.id.pair];
  if (account.id.said_by == Role::writer) {
    const Account::OfWriter& said = account.by_writer;
    pair.publisher = {.age = age,
                      .sent = said.sent,
                      .withheld = said.withheld,
                      .dropped = said.dropped,
                      .retained = said.retained,
                      .bytes_sent = said.bytes_sent,
                      .bytes_saved = said.bytes_saved,
                      .diverted = said.diverted,
                      .too_large_bytes = said.too_large_bytes,
                      .chunk_bytes = said.chunk_bytes};
  } else {
    pair.subscriber = {.age = age, .received = account.by_reader.received, .lost = account.by_reader.lost};
  }
}

}  // namespace sft::core
