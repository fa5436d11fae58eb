// The accounts of pairs that other nodes have reported. Accounts that are not reported again are dropped.
// The number of accounts is limited. If a process reports too many accounts, the newest accounts of this
// process are dropped, and those of other processes remain (table_shares.h). Uses no clock, thread or I/O.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>

#include "core/control/control.h"
#include "core/negotiation/table_shares.h"
#include "core/platform/clock.h"
#include "sft/domain.h"

namespace sft::core {

using PairAccounts = std::map<PairId, DomainSnapshot::Account>;

class AccountTable {
 public:
  struct Limits {
    std::size_t accounts = 4096;
    std::size_t of_announcer = 1024;
    /// The time for which an account is kept without a new report. Within this time a node can report 300
    /// accounts, if no report is lost.
    std::chrono::milliseconds kept_for{10'000};
  };
  AccountTable() : AccountTable(Limits{}) {}
  explicit AccountTable(const Limits& limits);

  /// Enters an account. `by` is the announcer of the endpoint whose node has counted.
  void enter(const Account& account, AnnouncerId by, Time now);
  void clear();
  /// Returns all accounts that were reported within `kept_for`, with their ages.
  PairAccounts accounts(Time now);

 private:
  struct Entry {
    Account account;
    AnnouncerId by = 0;
    std::uint64_t number = 0;  ///< identifies this entry in shares_
    Time at{};
  };
  using Entries = std::map<AccountId, Entry>;
  void erase(Entries::iterator entry);

  const Limits limits_;
  Entries entries_;
  std::map<std::uint64_t, AccountId> numbers_;
  TableShares shares_;
  std::uint64_t numbered_ = 0;
};

/// Adds the counts of one side of a pair to the account of the pair.
void add_to(PairAccounts& accounts, const Account& account, std::chrono::nanoseconds age);

}  // namespace sft::core
