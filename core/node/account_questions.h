// What our program wants to know of pairs of publishers and subscribers: whom the next sign of life asks, and
// what their nodes have answered. Everybody may say anything, so an answer counts only if
//
// - our program asks about the topic of a pair that is known,
// - and the participant that says it has announced the endpoint of which it says it.
//
// Answers that are not renewed are forgotten. There is room for as many as the limits say; a participant that
// answers without end costs itself its newest answers and others nothing (table_shares.h). Pure.
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
#include "core/platform/turns.h"
#include "sft/domain.h"

namespace sft::core {

using PairAccounts = std::map<PairId, PairAccount>;

class AccountQuestions {
 public:
  using Now = std::chrono::steady_clock::time_point;

  struct Limits {
    std::size_t answers = 4096;
    std::size_t of_announcer = 1024;
    /// Of an answer. In that time a node can tell 480 accounts, if no sign of life gets lost.
    std::chrono::milliseconds answers_last{10'000};
  };
  AccountQuestions() : AccountQuestions(Limits{}) {}
  explicit AccountQuestions(const Limits& limits);

  /// The program asks about a topic, as often as it likes, until it has taken all of that back.
  void ask(const std::string& topic) { ++topics_[topic]; }
  void ask_no_more(const std::string& topic);
  bool asks_about(const std::string& topic) const { return topics_.contains(topic); }
  bool asks() const { return !topics_.empty(); }

  /// Those of `endpoints`, which are others', that the next sign of life asks about: no more than it has room
  /// for, in turns.
  std::vector<EndpointId> take_turns(const std::set<EndpointId>& endpoints);

  /// An endpoint that is known, or null.
  using Known = std::function<const Endpoint*(EndpointId)>;
  void answered(const Assertion& sign, const Known& known, Now now);
  /// All answers that were given lately, with their ages.
  PairAccounts answers(Now now);

 private:
  struct Answer {
    Account account;
    AnnouncerId by = 0;
    std::uint64_t number = 0;  ///< by which it is known to shares_
    Now at{};
  };
  using Answers = std::map<AccountId, Answer>;
  bool counts(const Account& account, const Assertion& sign, const Known& known) const;
  void enter(const Account& account, AnnouncerId by, Now now);
  void forget_old(Now now);
  void erase(Answers::iterator answer);

  const Limits limits_;
  std::map<std::string, std::size_t> topics_;  ///< and how often the program asks about each
  Turns<EndpointId> turns_;
  Answers answers_;
  std::map<std::uint64_t, AccountId> numbers_;
  TableShares shares_;
  std::uint64_t numbered_ = 0;
};

/// Adds what one side has told of a pair to what is known of it.
void add_to(PairAccounts& accounts, const Account& account, std::chrono::nanoseconds age);

}  // namespace sft::core
