#include "core/node/reports.h"

#include <optional>
#include <utility>

namespace sft::core {

namespace {

/// Adds the counts of one side of a pair to the account of the pair.
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

}  // namespace

void Reports::ask(const std::string& topic) {
  ++topics_[topic];
  inquire(std::chrono::steady_clock::now());
}

void Reports::ask_for_progress(Time now) {
  progress_until_ = now + asks_for_progress;
  inquire(now);
}

void Reports::ask_no_more(const std::string& topic) {
  const auto asked = topics_.find(topic);
  if (asked != topics_.end() && --asked->second == 0) topics_.erase(asked);
  if (topics_.empty()) reported_.clear();
}

void Reports::inquire(Time now) {
  std::set<Inquiry> wanted;
  for (const auto& [topic, times] : topics_) wanted.insert({.topic = topic, .wants_accounts = true});
  if (now < progress_until_) wanted.insert(Inquiry{});
  for (auto& [id, reader] : ours_.readers) {
    if (reader.awaits_reports(now)) wanted.insert({.topic = reader.core().spec().topic});
  }
  if (wanted == inquired_) return;
  inquired_ = std::move(wanted);
  discovery_.inquire(inquired_);
}

/// Enters the accounts of a report. Discovery has checked that the reporting process owns the endpoints. An
/// account is entered only if the other endpoint of the pair is known, too.
void Reports::received(const NodeReport& report, Time now) {
  for (const Account& account : report.accounts) {
    const TableEntry* const writer = negotiation_.table().find(account.id.pair.writer);
    const TableEntry* const reader = negotiation_.table().find(account.id.pair.reader);
    if (reader == nullptr || reader->endpoint.role != Role::reader) continue;
    const std::string& topic = reader->endpoint.topic;
    if (!asks_about(topic)) continue;
    const bool is_pair =
        writer != nullptr && writer->endpoint.role == Role::writer && writer->endpoint.topic == topic;
    const bool hears_dds =
        account.id.said_by == Role::reader && vanilla_.knows_writer(account.id.pair.writer, topic);
    if (!is_pair && !hears_dds) continue;
    if (reported_.size() < accounts_kept_max || reported_.contains(account.id))
      reported_.insert_or_assign(account.id, Reported{account, now});
  }
}

NodeReport Reports::take(Time now) {
  NodeReport report;
  reported_at_ = now;
  const auto [asked, made] = discovery_.inquiries();
  const bool again = std::exchange(inquiries_made_, made) != made;
  if (asked.empty()) return report;
  report.progress = take_progress(asked, again);
  report.accounts = take_accounts(asked);
  return report;
}

/// Returns the progress of writers that have sent samples since their last report. If there are too many
/// for one report, writers take turns. If `again` is true, another node has begun to inquire, and the
/// progress of all writers is returned.
std::vector<Progress> Reports::take_progress(const std::set<Inquiry>& asked, bool again) {
  const bool of_all_topics = asked.contains({});
  std::vector<Progress> all;
  progress_turns_.go_round(ours_.writers, progress_max, [&](auto& item) {
    if (!of_all_topics && !asked.contains({.topic = item.second.core().spec().topic})) return false;
    const std::optional<Progress> progress = item.second.take_progress(again);
    if (progress) all.push_back(*progress);
    return progress.has_value();
  });
  return all;
}

std::vector<Account> Reports::take_accounts(const std::set<Inquiry>& asked) {
  const std::set<AccountId> all = accounts_of_ours(
      [&](const std::string& topic) { return asked.contains({.topic = topic, .wants_accounts = true}); });
  std::vector<Account> accounts;
  account_turns_.go_round(all, accounts_max, [&](const AccountId& id) {
    accounts.push_back(account(id));
    return true;
  });
  return accounts;
}

/// Returns the ids of the accounts of all matching pairs of this node's endpoints on the topics for which
/// `is_of` returns true. Only pairs that match have counts.
template <class IsOf>
std::set<AccountId> Reports::accounts_of_ours(IsOf is_of) const {
  std::set<AccountId> accounts;
  for (const auto& [own, writer] : ours_.writers) {
    if (!is_of(writer.core().spec().topic)) continue;
    for (const EndpointId reader : writer.matching_readers()) accounts.insert({{own, reader}, Role::writer});
  }
  for (const auto& [own, reader] : ours_.readers) {
    if (!is_of(reader.core().spec().topic)) continue;
    for (const EndpointId writer : reader.matching_writers()) accounts.insert({{writer, own}, Role::reader});
  }
  return accounts;
}

/// Returns the counts of an account. `id` must be one of accounts_of_ours().
Account Reports::account(const AccountId& id) const {
  Account account{.id = id};
  if (id.said_by == Role::reader) {
    account.by_reader = ours_.readers.at(id.pair.reader).ports().account_of(id.pair.writer);
  } else {
    account.by_writer = ours_.writers.at(id.pair.writer).account_of(id.pair.reader);
  }
  return account;
}

/// Returns the accounts that other nodes have reported, and the present ones of this node's endpoints.
PairAccounts Reports::accounts(Time now) {
  std::erase_if(reported_, [&](const auto& item) { return now - item.second.at >= account_kept_for; });
  PairAccounts known;
  for (const auto& [id, reported] : reported_) add_to(known, reported.account, now - reported.at);
  for (const AccountId& id : accounts_of_ours([this](const std::string& topic) { return asks_about(topic); }))
    add_to(known, account(id), {});
  return known;
}

}  // namespace sft::core
