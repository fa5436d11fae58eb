#include "core/node/local_reader.h"

#include <algorithm>
#include <utility>

#include "core/names/names.h"
#include "core/report/events.h"

namespace sft::core {

namespace {

/// The maximum number of connections, of all readers of the node, that are not attached yet. The daemon of
/// a host has 1,024 ports for all readers, and forged publishers must not occupy all of them.
constexpr std::size_t unattached_max = 128;
constexpr std::chrono::milliseconds attach_again_after{500};
// The pause after a disconnection, in which the writer's node can notice it.
constexpr std::chrono::milliseconds restart_pause{500};
/// The time for which samples in lost memory can still be taken. The next daemon cannot use the memory
/// until this time has passed. A newly started sftd waits at most 1.2 s until the memory is released, and a
/// node may need 1 s of that to notice the loss.
constexpr std::chrono::milliseconds lost_memory_kept{200};
constexpr std::chrono::seconds network_preferred_min{2}, network_preferred_max{60};

/// Returns true if the writer's announcement has changed. The first announcement may have been forged, so a
/// later announcement replaces it.
bool says_otherwise(Source wanted, const Source& before) {
  wanted.history_first = before.history_first;  // the value matters only when a connection begins
  return wanted != before;
}

bool is_waited_for(const Source& source) { return source.reliable && source.waits; }

}  // namespace

LocalReader::LocalReader(NodeContext& node, const Endpoint& endpoint, Parts parts)
    : node_(node),
      core_(std::move(parts.core)),
      selection_(parts.selection),
      feed_(core_->feed(selection_)),
      network_(std::move(parts.network)),
      vanilla_(node, *core_, feed_),
      callback_(selection_ == 0 ? std::make_unique<CallbackMonitor>(core_) : nullptr),
      requested_(endpoint.qos),
      accepted_({feed_.spec().selection, endpoint.request.min_period_us},
                endpoint.qos.reliability == Reliability::reliable) {
  accept();
}

void LocalReader::close() {
  ports().set_network(nullptr);
  ports().set_memory(nullptr);
  ports().release_lost_memory(true);
}

void LocalReader::reconcile(std::size_t& unattached) {
  std::vector<Hearing> wanted = node_.negotiation.hearing(feed_.spec().id);
  for (const Hearing& hearing : wanted) connect(hearing, writers_[hearing.source.writer], unattached);
  vanilla_.reconcile(std::chrono::steady_clock::now());
  for (const Hearing& hearing : vanilla_.hearing()) {
    writers_[hearing.source.writer].hearing = hearing;
    wanted.push_back(hearing);
  }
  disconnect_departed(wanted);
  ports().hears(wanted);
  // The writer may have been killed between passing on its last sample and ringing the doorbell.
  core_->wake();
  has_changes_ = true;
  // The writers that match are watched, if the subscriber has requested a deadline or a lease.
  for (auto& [id, writer] : writers_) {
    if (!writer.hearing.status.matched) writer.monitor.reset();
    if (!writer.hearing.status.matched || writer.monitor) continue;
    const RequestMonitor monitor(writer.hearing.offered, requested_, ports().arrivals(id),
                                 std::chrono::steady_clock::now());
    if (monitor.pace()) writer.monitor = monitor;
  }
}

/// Connects to or disconnects from one writer, as wanted. Notes the connections that are then in force.
void LocalReader::connect(const Hearing& wanted, Writer& writer, std::size_t& unattached) {
  const Hearing before = std::exchange(writer.hearing, wanted);
  if (!wanted.memory) writer.memory = {};
  if (!wanted.network) writer.network = {};
  departed_.erase(wanted.source.writer);
  writer.hearing.network = connect_network(wanted, before, writer.network);
  writer.hearing.memory = connect_memory(wanted, before, writer.memory, unattached);
}

bool LocalReader::connect_network(const Hearing& wanted, const Hearing& before, Retry& retry) {
  if (wanted.network == before.network) {
    if (wanted.network && says_otherwise(wanted.source, before.source)) network_->announced(wanted.source);
    return wanted.network;
  }
  if (wanted.network)
    return node_.attempts.over_network(retry, [&] { return network_->connect(wanted.source); });
  network_->disconnect(wanted.source.writer);
  return false;
}

/// Connects to or disconnects from one writer in shared memory, as wanted. If the writer starts or stops
/// waiting for the reader, the connection is set up anew, because the kind of the queue depends on this.
bool LocalReader::connect_memory(const Hearing& wanted, const Hearing& before, Retry& retry,
                                 std::size_t& unattached) {
  const auto attempt = [&] {
    return node_.attempts.in_memory(retry, [&] { return connect_in_memory(wanted.source); });
  };
  if (!wanted.memory) {
    if (before.memory && memory_ != nullptr) memory_->disconnect(wanted.source.writer);
    return false;
  }
  if (before.memory) {
    if (is_waited_for(wanted.source) == is_waited_for(before.source)) return true;
    memory_->disconnect(wanted.source.writer);
    return attempt();
  }
  if (unattached >= unattached_max) {
    retry.hold(std::chrono::steady_clock::now() + attach_again_after);
    return false;
  }
  const bool connected = attempt();
  unattached += connected ? 1 : 0;
  return connected;
}

Result<void> LocalReader::connect_in_memory(const Source& source) {
  if (memory_ == nullptr) {
    const SubscriberOptions& options = core_->spec().options;
    auto port = node_.memory->open_reader({.id = feed_.spec().id,
                                           .type = &core_->type(),
                                           .depth = options.depth,
                                           .listener = core_.get(),
                                           .doorbell = node_.negotiation.local(feed_.spec().id)->doorbell,
                                           .max_held = options.max_held,
                                           .depth_bytes = options.depth_bytes});
    if (!port) return tl::unexpected(port.error());
    memory_ = std::move(*port);
    ports().set_memory(memory_);
  }
  return memory_->connect(source);
}

void LocalReader::disconnect_departed(const std::vector<Hearing>& wanted) {
  std::set<EndpointId> present;
  for (const Hearing& hearing : wanted) present.insert(hearing.source.writer);
  bool changed = false;
  std::erase_if(writers_, [&](const auto& item) {
    const auto& [id, writer] = item;
    if (present.contains(id)) return false;
    if (writer.hearing.network) departed_[id] = std::chrono::steady_clock::now();
    if (writer.hearing.memory && memory_ != nullptr) memory_->disconnect(id);
    changed |= node_.negotiation.connection_changed(feed_.spec().id, id, false, false);
    return true;
  });
  if (changed) send_request();
}

std::size_t LocalReader::unattached() const {
  return static_cast<std::size_t>(std::ranges::count_if(writers_, [this](const auto& item) {
    return item.second.hearing.memory && memory_ != nullptr && !memory_->connected(item.first);
  }));
}

LocalReader::Connections LocalReader::look_after_connections() {
  Connections connections;
  bool request_changed = false;
  for (const auto& [writer, known] : writers_) {
    const Hearing& hearing = known.hearing;
    const bool listening = hearing.network && network_->connected(writer);
    const bool attached = hearing.memory && memory_ != nullptr && memory_->connected(writer);
    const bool awaits_history = hearing.source.history_first;
    request_changed |= node_.negotiation.connection_changed(feed_.spec().id, writer, listening, attached);
    if (listening && awaits_history) request_changed |= look_after_history(*network_, writer, connections);
    if (attached && awaits_history && !hearing.network)
      request_changed |= look_after_history(*memory_, writer, connections);
    connections.waiting |= hearing.memory && !attached;
    if (attached) connections.arrivals += memory_->arrivals(writer);
  }
  if (request_changed) send_request();
  connections.changed |= request_changed;
  return connections;
}

/// Returns true if retained samples have begun to arrive. The request must contain this fact.
bool LocalReader::look_after_history(const ReaderPort& port, EndpointId writer, Connections& connections) {
  const HistoryProgress progress = port.history(writer);
  if (progress == HistoryProgress::awaited) return false;
  if (progress == HistoryProgress::came)
    connections.changed |= node_.negotiation.history_came(feed_.spec().id, writer);
  return node_.negotiation.history_began(feed_.spec().id, writer);
}

void LocalReader::drop_memory() {
  ports().lose_memory();
  memory_lost_at_ = std::chrono::steady_clock::now();
  memory_.reset();
  for (auto& [id, writer] : writers_) {
    writer.hearing.memory = false;
    writer.memory = {};
  }
}

bool LocalReader::may_try_again(Time now) const {
  return vanilla_.is_due(now) || std::ranges::any_of(writers_, [&](const auto& item) {
           const Writer& writer = item.second;
           return node_.attempts.may_retry_in_memory(writer.memory, now) || writer.network.due_again(now);
         });
}

bool LocalReader::requirement_changed() {
  has_changes_ = true;  // status() shows the new requirement already
  const Wanted wanted{feed_.required(), ports().min_period_us()};
  if (!node_.negotiation.requirement_changed(feed_.spec().id, wanted)) return false;
  const Time now = std::chrono::steady_clock::now();
  const Wanted& before = accepted_.latest();
  const bool of_the_same_samples = wanted.min_period_us == before.min_period_us &&
                                   wanted.selection.gate_hash() == before.selection.gate_hash();
  if (!of_the_same_samples) others_asked_at_ = now;
  accepted_.asks_for(wanted, now);
  accept();
  send_request();
  return true;
}

void LocalReader::accept() {
  if (network_ != nullptr) network_->accept(accepted_.all());
}

void LocalReader::send_request() {
  const Request& request = node_.negotiation.local(feed_.spec().id)->request;
  has_changes_ = true;
  feed_.requests(accepted_.latest().selection, request.sequence);
  node_.discovery.send(request);
}

void LocalReader::forget_what_was_in_flight(Time now) {
  if (memory_lost_at_ != Time::max() && ports().release_lost_memory(now - memory_lost_at_ > lost_memory_kept))
    memory_lost_at_ = Time::max();
  if (accepted_.look(now)) accept();
  if (others_asked_at_ != Time::max() && now - others_asked_at_ > AcceptedRequests::in_flight_max) {
    others_asked_at_ = Time::max();
    ports().forget_former_conditions();
  }
  std::erase_if(departed_, [&](const auto& departed) {
    if (now - departed.second <= AcceptedRequests::in_flight_max) return false;
    network_->disconnect(departed.first);
    return true;
  });
}

void LocalReader::watch_promises(Time now) {
  for (auto& [id, writer] : writers_) {
    if (!writer.monitor) continue;
    const std::uint64_t missed = writer.monitor->look(ports().arrivals(id), now);
    has_changes_ |= ports().keeps_promises(id, missed, writer.monitor->alive());
  }
}

void LocalReader::asserted(const std::vector<EndpointId>& writers) {
  for (const EndpointId id : writers) {
    const auto writer = writers_.find(id);
    if (writer != writers_.end() && writer->second.monitor) writer->second.monitor->asserted();
  }
}

std::chrono::nanoseconds LocalReader::pace(std::chrono::nanoseconds longest) const {
  for (const auto& [id, writer] : writers_)
    if (writer.monitor) longest = std::min(longest, writer.monitor->pace().value_or(longest));
  return longest;
}

bool LocalReader::restart_stalled(const std::vector<Progress>& reported, bool held_up, Time now) {
  bool restarted = false;
  for (auto& [id, writer] : writers_) {
    if (!is_stalled(writer, reported, held_up, now)) continue;
    restart(writer, now);
    restarted = true;
  }
  return restarted;
}

bool LocalReader::awaits_reports(Time now) {
  if (requested_.liveliness_lease.count() != 0) return true;
  return std::ranges::any_of(writers_, [&](auto& item) { return item.second.watchdog.needs_progress(now); });
}

bool LocalReader::is_stalled(Writer& from, const std::vector<Progress>& reported, bool held_up, Time now) {
  const Hearing& hearing = from.hearing;
  const EndpointId writer = hearing.source.writer;
  const Request& request = node_.negotiation.local(feed_.spec().id)->request;
  const bool attached = holds(request.attached, writer);
  const bool connected = attached || holds(request.listening, writer);
  // A publisher that waits for its readers sends nothing until the program takes the samples that have
  // arrived.
  const bool waits = hearing.source.waits && ports().available();
  // A long time may pass until a sample fulfils the conditions.
  const bool has_conditions = !accepted_.latest().selection.gate().is_open();
  if (!connected || waits || held_up || has_conditions) {
    from.watchdog.excuse();
    return false;
  }
  const auto named = std::ranges::find(reported, writer, &Progress::writer);
  const bool lossy = !attached && !hearing.source.reliable;
  std::uint64_t signs = ports().arrivals(writer);
  // Parts of samples may arrive although no sample becomes complete.
  if (lossy && node_.network != nullptr) signs += node_.network->counters().incomplete;
  const ReaderPort* by = network_.get();
  if (attached) by = memory_.get();
  const bool awaits_history =
      hearing.source.history_first && by != nullptr && by->history(writer) != HistoryProgress::came;
  return from.watchdog.look(
      named == reported.end() ? nullptr : &*named, signs,
      {.reliable = !lossy, .min_period_us = request.min_period_us, .awaits_history = awaits_history}, now);
}

/// Sets up a connection anew. A request tells the writer that the reader has stopped receiving, and a later
/// request tells it that the reader receives again. So both sides begin anew. If nothing arrived through
/// shared memory, UDP is used for a while before shared memory is tried again.
void LocalReader::restart(Writer& from, Time now) {
  Hearing& hearing = from.hearing;
  const EndpointId writer = hearing.source.writer;
  const bool attached = memory_ != nullptr && hearing.memory && memory_->connected(writer);
  if (hearing.network) {
    network_->disconnect(writer);
    from.network.hold(now + restart_pause);
  }
  if (hearing.memory) {
    if (memory_ != nullptr) memory_->disconnect(writer);
    const bool prefers_network = attached && hearing.network;
    if (prefers_network) {
      from.network_preferred =
          std::clamp(from.network_preferred * 2, network_preferred_min, network_preferred_max);
    }
    from.memory.hold(now + (prefers_network ? Time::duration(from.network_preferred) : restart_pause));
  }
  hearing.network = hearing.memory = false;
  if (node_.negotiation.connection_changed(feed_.spec().id, writer, false, false)) send_request();
  ports().restarted(writer);
  node_.log.write(LogLevel::warning, text_of_topic(core_->spec().topic, selection_) + ", node " +
                                         in_quotes(hearing.status.node) +
                                         ": it sends, but nothing arrives by " +
                                         to_string(attached ? TransportKind::shm : TransportKind::udp) +
                                         "; the connection is set up anew (restart " +
                                         std::to_string(from.watchdog.restarts()) + ")");
}

/// Reports events. States are copied and compared only if a change is possible.
void LocalReader::report_events() {
  const std::uint64_t losses = ports().losses();
  has_changes_ |= std::exchange(losses_reported_, losses) != losses;
  has_changes_ |= ports().held_too_many() != reported_.held_too_many;
  if (!std::exchange(has_changes_, false)) return;
  core::report_events(
      *core_, reported_, node_.log, [this] { return feed_.status(); },
      [this](const SubscriberStatus& before, const SubscriberStatus& now) {
        std::vector<Event> events = events_between(before, now, core_->type(), requested_.reliability);
        for (Event& event : events) event.selection = static_cast<std::uint32_t>(selection_);
        return events;
      });
}

std::vector<EndpointId> LocalReader::matching_writers() const {
  std::vector<EndpointId> matching;
  for (const auto& [id, writer] : writers_) {
    if (writer.hearing.status.matched) matching.push_back(id);
  }
  return matching;
}

}  // namespace sft::core
