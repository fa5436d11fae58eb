// What the reconciler says and hears of life: of nodes and writers, of promises kept, and of samples that
// should have arrived.
#include <algorithm>
#include <utility>

#include "core/control/names.h"
#include "core/node/reconciler.h"

namespace sft::core {

namespace {
constexpr std::chrono::milliseconds told_more_pause{500};
constexpr int looks_in_callback_max = 4;  // in a row
constexpr std::chrono::seconds held_up_for{1};
constexpr std::chrono::milliseconds restart_pause{500};  // for the other side to see that nobody listens
constexpr std::chrono::seconds udp_preferred_min{2}, udp_preferred_max{60};
}  // namespace

void Reconciler::watch_promises(Now now) {
  std::vector<EndpointId> living;
  for (auto& [id, writer] : writers_) {
    if (watch_offer(writer, now)) living.push_back(id);
  }
  if (!living.empty() || now - told_of_life_at_ >= discovery_.life_signs().pause)
    tell_of_life(std::move(living), now);
  for (auto& [id, reader] : readers_) {
    for (auto& [writer, watch] : reader.watched) {
      watch.look(reader.core->ports().arrivals(writer), now);
      reader.has_news |= reader.core->ports().keeps_promises(writer, watch.deadlines_missed(), watch.alive());
    }
  }
}

/// Whether the writer's readers have to be told that it lives.
bool Reconciler::watch_offer(Writer& writer, Now now) {
  const OfferWatch::Signs signs = writer.core->signs();
  writer.watch.look(signs, now);
  writer.has_news |= writer.core->keeps_promises(writer.watch.deadlines_missed(), writer.watch.alive());
  if (!writer.watch.rests(now)) writer.core->listen_for_assertions();
  return writer.in_force && writer.in_force->lease_requested &&
         writer.watch.assertion_due(signs, writer.in_force->samples_tell, now);
}

/// At once, so that what the program does in time is in time for others.
void Reconciler::program_asserts(EndpointId id) {
  const auto writer = writers_.find(id);
  if (writer == writers_.end()) return;
  const Now now = std::chrono::steady_clock::now();
  if (watch_offer(writer->second, now)) tell_of_life({id}, now);
}

/// What tells of a writer tells of the node, too, and of how far its writers are.
void Reconciler::tell_of_life(std::vector<EndpointId> writers, Now now) {
  const Assertion assertion = sign_of_life(std::move(writers), now);
  told_of_life_at_ = now;
  discovery_.assert_liveliness(assertion);
  liveliness_asserted(assertion);  // our own readers
}

/// What is told beside that goes with no more than two signs in a second: who keeps a short lease gives far
/// more.
Assertion Reconciler::sign_of_life(std::vector<EndpointId> writers, Now now) {
  Assertion sign{id_, std::move(writers)};
  if (now < told_more_at_ + told_more_pause) return sign;
  sign.progress = progress_to_tell();
  sign.asked_about = questions_to_ask();
  sign.accounts = accounts_to_tell(now);
  if (!sign.progress.empty() || !sign.asked_about.empty() || !sign.accounts.empty()) told_more_at_ = now;
  return sign;
}

void Reconciler::node_lost(NodeId id) {
  if (silence_.is_lost(id, std::chrono::steady_clock::now())) dirty_ |= negotiation_.node_lost(id);
}

void Reconciler::liveliness_asserted(const Assertion& assertion, Now now) {
  silence_.lives(assertion.node);
  dirty_ |= negotiation_.node_returned(assertion.node);
  for (const Progress& progress : assertion.progress) negotiation_.progressed(assertion.node, progress);
  for (const EndpointId id : assertion.asked_about) {
    if (is_ours(id)) answers_.asked(id, now);
  }
  questions_.answered(
      assertion, [this](EndpointId id) { return negotiation_.known(id); }, now);
  for (auto& [id, reader] : readers_) {
    for (const EndpointId writer : assertion.writers) {
      if (const auto watch = reader.watched.find(writer); watch != reader.watched.end())
        watch->second.asserted();
    }
  }
  look_for_the_deaf(assertion, now);
}

/// Of those writers that have sent something since they were named last.
std::vector<Progress> Reconciler::progress_to_tell() {
  std::vector<Progress> progress;
  progress_turns_.go_round(writers_, progress_max, [&](auto& item) {
    Writer& writer = item.second;
    if (!writer.in_force || (writer.in_force->shm.empty() && writer.in_force->udp.empty())) return false;
    const std::uint64_t published = writer.core->signs().published;
    if (published == writer.progress_told) return false;
    writer.progress_told = published;
    progress.push_back(writer.core->progress());
    return true;
  });
  return progress;
}

/// About the endpoints of others on the topics that the program asks about.
std::vector<EndpointId> Reconciler::questions_to_ask() {
  if (!questions_.asks()) return {};
  std::set<EndpointId> others;
  for (const Endpoint* endpoint : negotiation_.present()) {
    if (!is_ours(endpoint->id) && questions_.asks_about(endpoint->topic)) others.insert(endpoint->id);
  }
  return questions_.take_turns(others);
}

std::vector<Account> Reconciler::accounts_to_tell(Now now) {
  std::set<AccountId> all;
  for (const EndpointId own : answers_.asked_about(now)) add_accounts_of(own, all);
  std::vector<Account> accounts;
  for (const AccountId& id : answers_.take_turns(all)) accounts.push_back(account(id));
  return accounts;
}

/// Of all pairs that one of our endpoints matches: there is nothing to count of the others.
void Reconciler::add_accounts_of(EndpointId own, std::set<AccountId>& accounts) const {
  if (const auto writer = writers_.find(own); writer != writers_.end() && writer->second.in_force) {
    for (const ReaderStatus& reader : writer->second.in_force->readers) {
      const bool matches = !reader.incompatible_type && reader.incompatible_policy == QosPolicy::none;
      if (matches) accounts.insert({{own, reader.id}, Role::writer});
    }
  }
  if (const auto reader = readers_.find(own); reader != readers_.end()) {
    for (const auto& [writer, hearing] : reader->second.heard) {
      if (hearing.status.matched) accounts.insert({{writer, own}, Role::reader});
    }
  }
}

/// One of add_accounts_of().
Account Reconciler::account(const AccountId& id) const {
  Account account{.id = id};
  if (id.said_by == Role::reader) {
    account.by_reader = readers_.at(id.pair.reader).core->ports().account_of(id.pair.writer);
    return account;
  }
  const Delivered delivered = writers_.at(id.pair.writer).core->delivered(id.pair.reader);
  account.by_writer = {.sent = delivered.sent,
                       .withheld = delivered.withheld,
                       .dropped = delivered.dropped,
                       .retained = delivered.retained,
                       .bytes_sent = delivered.bytes,
                       .bytes_saved = delivered.bytes_saved};
  return account;
}

/// A callback that takes long may hold up the thread that receives for all subscribers of the node.
void Reconciler::look_for_callbacks_under_way(Now now) {
  for (auto& [id, reader] : readers_) {
    reader.looks_in_callback = reader.core->is_called_back() ? reader.looks_in_callback + 1 : 0;
    if (reader.looks_in_callback >= looks_in_callback_max) held_up_at_ = now;
  }
}

/// Sets connections up anew by which nothing arrives, although their writer sends.
void Reconciler::look_for_the_deaf(const Assertion& assertion, Now now) {
  for (auto& [id, reader] : readers_) {
    for (auto& [writer, hearing] : reader.heard) {
      const Endpoint* const endpoint = negotiation_.known(writer);
      if (endpoint == nullptr || endpoint->node_id != assertion.node) continue;
      if (is_deaf(id, reader, hearing, assertion, now)) restart(id, reader, hearing, now);
    }
  }
}

bool Reconciler::is_deaf(EndpointId id, Reader& reader, const Hearing& hearing, const Assertion& assertion,
                         Now now) {
  const EndpointId writer = hearing.source.writer;
  const Request& request = negotiation_.local(id)->request;
  const auto holds = [&](const auto& writers) { return std::ranges::find(writers, writer) != writers.end(); };
  const bool attached = holds(request.attached);
  ArrivalWatchdog& watchdog = reader.watchdogs[writer];
  const bool connected = attached || holds(request.listening);
  // A publisher that waits for its readers has nothing to send while nobody takes what has come.
  const bool waits = hearing.source.waits && reader.core->available();
  if (!connected || waits || now - held_up_at_ < held_up_for) {
    watchdog.excuse();
    return false;
  }
  const auto named = std::ranges::find(assertion.progress, writer, &Progress::writer);
  const bool lossy = !attached && !hearing.source.reliable;
  std::uint64_t signs = reader.core->ports().arrivals(writer);
  if (lossy && udp_ != nullptr) signs += udp_->counters().incomplete;  // parts of it may come
  const ReaderPort* const by = attached ? reader.shm.get() : reader.udp.get();
  const bool awaits_history =
      hearing.source.history_first && by != nullptr && by->history(writer) != HistoryProgress::came;
  return watchdog.look(
      named == assertion.progress.end() ? nullptr : &*named, signs,
      {.reliable = !lossy, .min_period_us = request.min_period_us, .awaits_history = awaits_history}, now);
}

/// It is said that the reader listens no more, and a moment later that it does: both sides begin anew. Shared
/// memory that was deaf has its turn again after a while in which UDP has it.
void Reconciler::restart(EndpointId id, Reader& reader, Hearing& hearing, Now now) {
  const EndpointId writer = hearing.source.writer;
  const bool attached = reader.shm != nullptr && hearing.shm && reader.shm->connected(writer);
  Connecting& connecting = reader.connecting[writer];
  if (hearing.udp) {
    reader.udp->disconnect(writer);
    connecting.udp.hold(now + restart_pause);
  }
  if (hearing.shm) {
    if (reader.shm != nullptr) reader.shm->disconnect(writer);
    if (attached && hearing.udp)
      connecting.udp_preferred =
          std::clamp(connecting.udp_preferred * 2, udp_preferred_min, udp_preferred_max);
    connecting.shm.hold(now +
                        (attached && hearing.udp ? Now::duration(connecting.udp_preferred) : restart_pause));
  }
  hearing.udp = hearing.shm = false;
  const bool listened = negotiation_.connection_changed(id, writer, TransportKind::udp, false);
  const bool was_attached = negotiation_.connection_changed(id, writer, TransportKind::shm, false);
  if (listened || was_attached) request_changed(id);
  dirty_ = true;
  reader.core->ports().restarted(writer);
  log_.write(LogLevel::warning, "topic " + in_quotes(reader.core->spec().topic) + ", node " +
                                    in_quotes(hearing.status.node) + ": it sends, but nothing arrives by " +
                                    to_string(attached ? TransportKind::shm : TransportKind::udp) +
                                    "; the connection is set up anew, for the " +
                                    std::to_string(reader.watchdogs.at(writer).restarts()) + ". time");
}

/// Those that it matches, if it asked for anything to be watched.
void Reconciler::watch(Reader& reader) {
  std::erase_if(reader.watched, [&](const auto& item) {
    const auto heard = reader.heard.find(item.first);
    return heard == reader.heard.end() || !heard->second.status.matched;
  });
  for (const auto& [writer, hearing] : reader.heard) {
    if (!hearing.status.matched || reader.watched.contains(writer)) continue;
    const RequestWatch watch(hearing.offered, reader.requested, reader.core->ports().arrivals(writer),
                             std::chrono::steady_clock::now());
    if (watch.pace()) reader.watched.emplace(writer, watch);
  }
}

std::vector<KnownEndpoint> Reconciler::known_endpoints() const {
  std::vector<KnownEndpoint> known;
  for (const Endpoint* endpoint : negotiation_.present()) {
    const Progress* const progress = negotiation_.progress_of(endpoint->id);
    known.push_back({*endpoint, progress == nullptr ? std::nullopt : std::optional(*progress)});
  }
  return known;
}

/// What others have told, and of our own endpoints what is true at present.
PairAccounts Reconciler::known_accounts(Now now) {
  PairAccounts known = questions_.answers(now);
  std::set<AccountId> ours;
  const auto look_at = [&](const auto& members) {
    for (const auto& [id, member] : members) {
      if (questions_.asks_about(member.core->spec().topic)) add_accounts_of(id, ours);
    }
  };
  look_at(writers_);
  look_at(readers_);
  for (const AccountId& id : ours) add_to(known, account(id), {});
  return known;
}

}  // namespace sft::core
