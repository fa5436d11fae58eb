// What the reconciler says and hears of life: of nodes and writers, of promises kept, and of samples that
// should have arrived.
#include <algorithm>
#include <utility>

#include "core/names.h"
#include "core/reconciler.h"

namespace sft::core {

namespace {
constexpr std::chrono::milliseconds progress_pause{500};
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
      watch.look(reader.core->arrivals(writer), now);
      reader.has_news |= reader.core->keeps_promises(writer, watch.deadlines_missed(), watch.alive());
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
  const Assertion assertion{id_, std::move(writers), progress_to_tell(now)};
  told_of_life_at_ = now;
  discovery_.assert_liveliness(assertion);
  liveliness_asserted(assertion);  // our own readers
}

void Reconciler::node_lost(NodeId id) {
  if (silence_.is_lost(id, std::chrono::steady_clock::now())) dirty_ |= negotiation_.node_lost(id);
}

void Reconciler::liveliness_asserted(const Assertion& assertion, Now now) {
  silence_.lives(assertion.node);
  dirty_ |= negotiation_.node_returned(assertion.node);
  for (const Progress& progress : assertion.progress) negotiation_.progressed(assertion.node, progress);
  for (auto& [id, reader] : readers_) {
    for (const EndpointId writer : assertion.writers) {
      if (const auto watch = reader.watched.find(writer); watch != reader.watched.end())
        watch->second.asserted();
    }
  }
  look_for_the_deaf(assertion, now);
}

/// Of those writers that have sent something since they were named last. Where there are too many for one
/// assertion they take turns.
std::vector<Progress> Reconciler::progress_to_tell(Now now) {
  std::vector<Progress> progress;
  if (now < progress_told_at_ + progress_pause) return progress;
  progress_told_at_ = now;
  const auto look = [&](auto from, auto to) {
    for (; from != to && progress.size() < progress_max; ++from) {
      auto& [id, writer] = *from;
      if (!writer.in_force || (writer.in_force->shm.empty() && writer.in_force->udp.empty())) continue;
      const std::uint64_t published = writer.core->signs().published;
      if (published == writer.progress_told) continue;
      writer.progress_told = published;
      progress.push_back(writer.core->progress());
      last_named_ = id;
    }
  };
  const auto begin = writers_.upper_bound(last_named_);
  look(begin, writers_.end());
  look(writers_.begin(), begin);
  return progress;
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
  std::uint64_t signs = reader.core->arrivals(writer);
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
  reader.core->restarted(writer);
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
    const RequestWatch watch(hearing.offered, reader.requested, reader.core->arrivals(writer),
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

}  // namespace sft::core
