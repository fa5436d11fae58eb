// Connections of our readers to the writers that they hear: when they are made, what they are told, and when
// one that failed is tried again.
#include <algorithm>
#include <utility>

#include "core/node/reconciler.h"

namespace sft::core {

namespace {

/// A host's daemon has 1,024 ports for all readers. Publishers that are made up must not take them all.
constexpr std::size_t unattached_max = 128;
constexpr std::chrono::milliseconds attach_again_after{500};

/// Whether it failed for the first time, or for another reason than before.
bool is_new_failure(Retry& retry, const Result<void>& outcome) {
  if (!outcome) return retry.failed(outcome.error().message, std::chrono::steady_clock::now());
  retry.succeeded();
  return false;
}

/// The first announcement of a writer that is heard may be somebody else's.
bool says_otherwise(Source wanted, const Source& before) {
  wanted.history_first = before.history_first;  // it counts when a connection begins
  return wanted != before;
}

bool is_waited_for(const Source& source) { return source.reliable && source.waits; }

}  // namespace

/// Whether it has begun to come.
bool Reconciler::look_after_history(EndpointId reader, const ReaderPort& port, EndpointId writer) {
  const HistoryProgress progress = port.history(writer);
  if (progress == HistoryProgress::awaited) return false;
  if (progress == HistoryProgress::came) dirty_ |= negotiation_.history_came(reader, writer);
  return negotiation_.history_began(reader, writer);
}

/// Tells writers which of our readers hear them by now. Whether some reader still waits for its connection in
/// shared memory.
bool Reconciler::look_after_connections() {
  bool waiting = false;
  for (auto& [id, reader] : readers_) {
    bool changed = false;
    for (const auto& [writer, hearing] : reader.heard) {
      const bool listening = hearing.udp && reader.udp->connected(writer);
      const bool attached = hearing.shm && reader.shm != nullptr && reader.shm->connected(writer);
      changed |= negotiation_.connection_changed(id, writer, TransportKind::udp, listening);
      changed |= negotiation_.connection_changed(id, writer, TransportKind::shm, attached);
      if (listening && hearing.source.history_first) changed |= look_after_history(id, *reader.udp, writer);
      if (attached && hearing.source.history_first && !hearing.udp)
        changed |= look_after_history(id, *reader.shm, writer);
      waiting |= hearing.shm && !attached;
    }
    if (changed) request_changed(id);
    dirty_ |= changed;
  }
  return waiting;
}

/// Unless it failed a moment ago: then not yet, and nothing at all of a daemon that did not answer. That
/// costs its deadline each time, during which the agent does nothing else.
bool Reconciler::try_shm(Retry& retry, const std::function<Result<void>()>& open) {
  const Now now = std::chrono::steady_clock::now();
  if (!retry.due(now) || !asking_daemon_.due(now)) return false;
  const Result<void> opened = open();
  const bool answered = opened || opened.error().code != Errc::unavailable;
  const bool is_news = is_new_failure(retry, opened);
  if (answered) asking_daemon_.succeeded();
  if ((answered || is_new_failure(asking_daemon_, opened)) && is_news)
    log_.write(LogLevel::warning, opened.error().message);
  return opened.has_value();
}

bool Reconciler::try_udp(Retry& retry, Reader& reader, const Source& source) {
  if (!retry.due(std::chrono::steady_clock::now())) return false;
  const Result<void> connected = reader.udp->connect(source);
  if (is_new_failure(retry, connected)) log_.write(LogLevel::warning, connected.error().message);
  return connected.has_value();
}

/// Whether something that failed and is still wanted has its turn again.
bool Reconciler::may_try_again(Now now) const {
  const auto shm_may = [&](const Retry& retry) { return retry.due_again(now) && asking_daemon_.due(now); };
  const auto writer_may = [&](const auto& item) { return shm_may(item.second.opening_shm); };
  const auto reader_may = [&](const auto& item) {
    return std::ranges::any_of(item.second.connecting, [&](const auto& connecting) {
      return shm_may(connecting.second.shm) || connecting.second.udp.due_again(now);
    });
  };
  return std::ranges::any_of(writers_, writer_may) || std::ranges::any_of(readers_, reader_may);
}

/// Connections in shared memory whose publishers have not shown up there.
std::size_t Reconciler::count_unattached() const {
  std::size_t count = 0;
  for (const auto& [id, reader] : readers_) {
    for (const auto& [writer, hearing] : reader.heard)
      count += hearing.shm && reader.shm != nullptr && !reader.shm->connected(writer) ? 1 : 0;
  }
  return count;
}

void Reconciler::reconcile_reader(EndpointId id, Reader& reader) {
  const std::vector<Hearing> wanted = negotiation_.hearing(id);
  std::map<EndpointId, Hearing> heard;
  for (const Hearing& hearing : wanted) {
    const auto before = reader.heard.find(hearing.source.writer);
    const bool known = before != reader.heard.end();
    heard[hearing.source.writer] = connect(id, reader, hearing, known ? before->second : Hearing{});
  }
  bool changed = false;
  for (const auto& [writer, before] : reader.heard) {
    if (heard.contains(writer)) continue;
    if (before.udp) reader.departed[writer] = std::chrono::steady_clock::now();
    if (before.shm && reader.shm != nullptr) reader.shm->disconnect(writer);
    changed |= negotiation_.connection_changed(id, writer, TransportKind::udp, false);
    changed |= negotiation_.connection_changed(id, writer, TransportKind::shm, false);
  }
  if (changed) request_changed(id);
  reader.heard = std::move(heard);
  std::erase_if(reader.connecting, [&](const auto& item) { return !reader.heard.contains(item.first); });
  std::erase_if(reader.watchdogs, [&](const auto& item) { return !reader.heard.contains(item.first); });
  reader.core->hears(wanted);
  reader.has_news = true;
  watch(reader);
}

/// Connects to and disconnects from one writer as wanted; returns what is in force then.
Hearing Reconciler::connect(EndpointId id, Reader& reader, const Hearing& wanted, const Hearing& before) {
  Hearing now = wanted;
  const EndpointId writer = wanted.source.writer;
  Connecting& connecting = reader.connecting[writer];
  if (!wanted.shm) connecting.shm = {};
  if (!wanted.udp) connecting.udp = {};
  reader.departed.erase(writer);
  if (wanted.udp != before.udp) {
    if (!wanted.udp) {
      reader.udp->disconnect(writer);
    } else {
      now.udp = try_udp(connecting.udp, reader, wanted.source);
    }
  } else if (wanted.udp && says_otherwise(wanted.source, before.source)) {
    reader.udp->announced(wanted.source);
  }
  if (wanted.shm && before.shm && is_waited_for(wanted.source) != is_waited_for(before.source)) {
    reader.shm->disconnect(writer);
    now.shm = try_shm(connecting.shm, [&] { return connect_shm(id, reader, wanted.source); });
  } else if (wanted.shm != before.shm) {
    if (!wanted.shm) {
      if (reader.shm != nullptr) reader.shm->disconnect(writer);
    } else if (unattached_ >= unattached_max) {
      now.shm = false;
      connecting.shm.hold(std::chrono::steady_clock::now() + attach_again_after);
    } else {
      now.shm = try_shm(connecting.shm, [&] { return connect_shm(id, reader, wanted.source); });
      unattached_ += now.shm ? 1 : 0;
    }
  }
  return now;
}

Result<void> Reconciler::connect_shm(EndpointId id, Reader& reader, const Source& source) {
  if (reader.shm == nullptr) {
    auto port =
        shm_->open_reader({id, &reader.core->type(), reader.core->spec().options.depth, reader.core.get(),
                           negotiation_.local(id)->doorbell, reader.core->spec().options.max_held});
    if (!port) return tl::unexpected(port.error());
    reader.shm = std::move(*port);
    reader.core->ports().set(TransportKind::shm, reader.shm);
  }
  return reader.shm->connect(source);
}

}  // namespace sft::core
