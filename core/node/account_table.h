// The accounts of pairs that other nodes have reported. Accounts that are not reported again are dropped.
// The number of accounts is limited. Uses no clock, thread or I/O.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>

#include "core/control/control.h"
#include "core/platform/clock.h"
#include "sft/domain.h"

namespace sft::core {

using PairAccounts = std::map<PairId, DomainSnapshot::Account>;

class AccountTable {
 public:
  /// The maximum number of accounts. Further accounts are refused.
  static constexpr std::size_t accounts_max = 4096;
  /// The time for which an account is kept without a new report. Within this time a node can report 300
  /// accounts, if no report is lost.
  static constexpr std::chrono::milliseconds kept_for{10'000};

  void enter(const Account& account, Time now);
  void clear() { entries_.clear(); }
  /// Returns all accounts that were reported within `kept_for`, with their ages.
  PairAccounts accounts(Time now);

 private:
  struct Entry {
    Account account;
    Time at{};
  };

  std::map<AccountId, Entry> entries_;
};

/// Adds the counts of one side of a pair to the account of the pair.
void add_to(PairAccounts& accounts, const Account& account, std::chrono::nanoseconds age);

}  // namespace sft::core
