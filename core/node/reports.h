// The inquiries of this node, its reports to nodes that inquire, and the accounts that other nodes have
// reported. A report contains the progress of publishers, the counts of both sides of pairs, and the living
// publishers for which nothing else shows that they are alive. Reports are best effort, so the contents of
// each are repeated. Used by the agent only.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "core/discovery/discovery.h"
#include "core/negotiation/negotiation.h"
#include "core/node/domain_snapshot.h"
#include "core/node/local_endpoints.h"
#include "core/node/vanilla_access.h"
#include "core/platform/clock.h"
#include "core/platform/turns.h"

namespace sft::core {

class Reports {
 public:
  /// The maximum number of accounts of other nodes that are kept. Further accounts are refused.
  static constexpr std::size_t accounts_kept_max = 4096;
  /// The time for which an account is kept without a new report. Within this time a node can report 300
  /// accounts, if no report is lost.
  static constexpr std::chrono::milliseconds account_kept_for{10'000};

  /// All arguments must outlive this object.
  Reports(const Negotiation& negotiation, LocalEndpoints& ours, Discovery& discovery,
          const VanillaAccess& vanilla)
      : negotiation_(negotiation), ours_(ours), discovery_(discovery), vanilla_(vanilla) {}

  // Functions for requests of the program.

  /// Asks other nodes for the accounts of all pairs on that topic, repeatedly, until ask_no_more() has been
  /// called as often as ask().
  void ask(const std::string& topic);
  void ask_no_more(const std::string& topic);
  /// Asks other nodes for the progress of all publishers, for a while.
  void ask_for_progress(Time now);
  /// Returns the known accounts of the pairs that the program asks about.
  PairAccounts accounts(Time now = std::chrono::steady_clock::now());

  /// Announces the inquiries of this node if they have changed.
  void inquire(Time now);
  /// Called when another node has reported on its own endpoints.
  void received(const NodeReport& report, Time now);

  bool is_due(Time now) const { return now >= reported_at_ + pause; }
  /// Returns the report that is due, without the list of living publishers. The report may be empty. The
  /// returned report counts as sent.
  NodeReport take(Time now);

 private:
  static constexpr std::chrono::milliseconds pause{900};  // chosen so that an idle node reports at each look
  static constexpr std::chrono::seconds asks_for_progress{10};

  struct Reported {
    Account account;
    Time at{};
  };

  bool asks_about(const std::string& topic) const { return topics_.contains(topic); }
  std::vector<Progress> take_progress(const std::set<Inquiry>& asked, bool again);
  std::vector<Account> take_accounts(const std::set<Inquiry>& asked);
  template <class IsOf>
  std::set<AccountId> accounts_of_ours(IsOf is_of) const;
  Account account(const AccountId& id) const;

  const Negotiation& negotiation_;
  LocalEndpoints& ours_;
  Discovery& discovery_;
  const VanillaAccess& vanilla_;
  /// The topics that the program asks about, each with the number of calls of ask().
  std::map<std::string, std::size_t> topics_;
  Time progress_until_{};
  std::set<Inquiry> inquired_;        ///< the inquiries of this node that are announced at present
  std::uint64_t inquiries_made_ = 0;  ///< the number of inquiries of other nodes at the last report
  Time reported_at_{};
  Turns<EndpointId> progress_turns_;
  Turns<AccountId> account_turns_;
  std::map<AccountId, Reported> reported_;  ///< the accounts that other nodes have reported
};

}  // namespace sft::core
