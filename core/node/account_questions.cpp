#include "core/node/account_questions.h"

#include <iterator>

namespace sft::core {

/// All answers are about topics that the program asks about, so that no topic has a share of its own.
AccountQuestions::AccountQuestions(const Limits& limits)
    : limits_(limits),
      shares_({.entries = limits.answers,
               .of_announcer = limits.of_announcer,
               .topic_shares_from = limits.answers,
               .of_topic = limits.answers}) {}

void AccountQuestions::ask_no_more(const std::string& topic) {
  const auto asked = topics_.find(topic);
  if (asked != topics_.end() && --asked->second == 0) topics_.erase(asked);
  while (!asks() && !answers_.empty()) erase(answers_.begin());
}

std::vector<EndpointId> AccountQuestions::take_turns(const std::set<EndpointId>& endpoints) {
  std::vector<EndpointId> next;
  turns_.go_round(endpoints, asked_about_max, [&](EndpointId id) {
    next.push_back(id);
    return true;
  });
  return next;
}

bool AccountQuestions::counts(const Account& account, const Assertion& sign, const Known& known) const {
  const auto& [pair, said_by] = account.id;
  const Endpoint* const writer = known(pair.writer);
  const Endpoint* const reader = known(pair.reader);
  if (writer == nullptr || writer->role != Role::writer) return false;
  if (reader == nullptr || reader->role != Role::reader) return false;
  if (writer->topic != reader->topic || !asks_about(writer->topic)) return false;
  const Endpoint& own = said_by == Role::writer ? *writer : *reader;
  return own.node_id == sign.node && own.announcer == sign.announcer;
}

void AccountQuestions::answered(const Assertion& sign, const Known& known, Time now) {
  if (sign.accounts.empty()) return;
  forget_old(now);
  for (const Account& account : sign.accounts) {
    if (counts(account, sign, known)) enter(account, sign.announcer, now);
  }
}

void AccountQuestions::enter(const Account& account, AnnouncerId by, Time now) {
  const auto before = answers_.find(account.id);
  if (before != answers_.end() && before->second.by == by) {
    before->second.account = account;
    before->second.at = now;
    return;
  }
  if (before != answers_.end()) erase(before);
  const TableShares::Admission admission = shares_.admit(by, {});
  if (!admission.granted) return;
  if (admission.instead_of) erase(answers_.find(numbers_.at(*admission.instead_of)));
  const std::uint64_t number = ++numbered_;
  shares_.enter(number, by, {});
  numbers_.emplace(number, account.id);
  answers_.emplace(account.id, Answer{account, by, number, now});
}

void AccountQuestions::erase(Answers::iterator answer) {
  shares_.remove(answer->second.number);
  numbers_.erase(answer->second.number);
  answers_.erase(answer);
}

void AccountQuestions::forget_old(Time now) {
  for (auto answer = answers_.begin(); answer != answers_.end();) {
    const auto next = std::next(answer);
    if (now - answer->second.at >= limits_.answers_last) erase(answer);
    answer = next;
  }
}

PairAccounts AccountQuestions::answers(Time now) {
  forget_old(now);
  PairAccounts accounts;
  for (const auto& [id, answer] : answers_) add_to(accounts, answer.account, now - answer.at);
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
                      .bytes_saved = said.bytes_saved};
  } else {
    pair.subscriber = {.age = age, .received = account.by_reader.received, .lost = account.by_reader.lost};
  }
}

}  // namespace sft::core
