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
