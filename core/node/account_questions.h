// The questions of our program about pairs of publishers and subscribers: which endpoints the next sign of
// life asks about, and what their nodes have answered. Anybody may say anything, so an answer counts only if
//
// - our program asks about the topic of a pair that is known,
// - and the participant that gives the answer has announced the endpoint whose account it is.
//
// Answers that are not renewed are forgotten. The limits say how many answers are kept. A participant that
// answers without end loses its own newest answers, and no other participant loses any (table_shares.h).
// Pure.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "core/control/control.h"
#include "core/negotiation/table_shares.h"
#include "core/platform/clock.h"
#include "core/platform/turns.h"
#include "sft/domain.h"

namespace sft::core {

using PairAccounts = std::map<PairId, DomainSnapshot::Account>;

class AccountQuestions {
 public:
  struct Limits {
    std::size_t answers = 4096;
    std::size_t of_announcer = 1024;
    /// How long an answer is kept. In that time a node can tell 480 accounts, if no sign of life gets lost.
    std::chrono::milliseconds answers_last{10'000};
  };
  AccountQuestions() : AccountQuestions(Limits{}) {}
  explicit AccountQuestions(const Limits& limits);

  /// The program asks about a topic until it has called ask_no_more() as often as ask().
  void ask(const std::string& topic) { ++topics_[topic]; }
  void ask_no_more(const std::string& topic);
  bool asks_about(const std::string& topic) const { return topics_.contains(topic); }
  bool asks() const { return !topics_.empty(); }

  /// The endpoints that the next sign of life asks about: as many of `endpoints`, which are other nodes', as
  /// there is room for, in turns.
  std::vector<EndpointId> take_turns(const std::set<EndpointId>& endpoints);

  /// Finds an endpoint by its id; null if it is not known.
  using Known = std::function<const Endpoint*(EndpointId)>;
  void answered(const Assertion& sign, const Known& known, Time now);
  /// All answers that were given lately, with their ages.
  PairAccounts answers(Time now);

 private:
  struct Answer {
    Account account;
    AnnouncerId by = 0;
    std::uint64_t number = 0;  ///< names this answer in shares_
    Time at{};
  };
  using Answers = std::map<AccountId, Answer>;
  bool counts(const Account& account, const Assertion& sign, const Known& known) const;
  void enter(const Account& account, AnnouncerId by, Time now);
  void forget_old(Time now);
  void erase(Answers::iterator answer);

  const Limits limits_;
  std::map<std::string, std::size_t> topics_;  ///< with the number of times that the program asks about each
  Turns<EndpointId> turns_;
  Answers answers_;
  std::map<std::uint64_t, AccountId> numbers_;
  TableShares shares_;
  std::uint64_t numbered_ = 0;
};

/// Adds what one side has told of a pair to what is known of it.
void add_to(PairAccounts& accounts, const Account& account, std::chrono::nanoseconds age);

}  // namespace sft::core
