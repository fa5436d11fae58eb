#include "core/node/reconciler.h"

#include <algorithm>
#include <iterator>
#include <utility>
#include <variant>

namespace sft::core {

namespace {
constexpr std::chrono::milliseconds tick_shortest{1};
constexpr std::chrono::seconds complaint_pause{1};
constexpr std::chrono::seconds held_up_for{1};
constexpr const char* remedy_of_long_callbacks =
    "open a node of its own for a long callback, or give its work to another thread";

/// Returns true if frequent looks are needed, because no event will report a change: an endpoint is lost,
/// retained samples are still being sent to a late reader, or a callback may take long.
bool has_to_be_watched(const Negotiation& negotiation, const LocalEndpoints& ours) {
  return negotiation.table().misses_peer() ||
         std::ranges::any_of(ours.writers, [](const auto& item) { return item.second.owes_history(); }) ||
         std::ranges::any_of(ours.readers, [](const auto& item) {
           const CallbackMonitor* const callback = item.second.callback();
           return item.second.core().is_called_back() ||
                  (callback != nullptr && callback->has_waiting_sample());
         });
}
}  // namespace

Reconciler::Reconciler(std::uint64_t network_id, SharedMemory* memory, Network* network, Discovery& discovery,
                       Dispatcher& dispatcher, NodeLog& log, VanillaAccess::Setup vanilla)
    : discovery_(discovery),
      dispatcher_(dispatcher),
      log_(log),
      transports_(memory, network, network_id, log),
      attempts_(log, memory),
      vanilla_(std::move(vanilla), log),
      context_{negotiation_, discovery, attempts_, log, memory, network, &vanilla_},
      reports_(negotiation_, ours_, discovery, vanilla_) {
  negotiation_.self_changed(transports_.self());
  if (network != nullptr) negotiation_.network_changed(transports_.addresses(), transports_.links());
}

void Reconciler::add_writer(const Endpoint& endpoint, std::shared_ptr<PublisherCore> core) {
  const TypeSupport& type = core->type();
  ours_.writers.try_emplace(endpoint.id, context_, endpoint, std::move(core));
  look_after_vanilla(std::chrono::steady_clock::now());
  negotiation_.local_added(endpoint, type);
  dirty_ = true;
  announce(endpoint.id);
}

void Reconciler::add_reader(const Endpoint& endpoint, LocalReader::Parts parts) {
  const bool is_first = parts.selection == 0;  // the core serves all selections, but is added to the
                                               // dispatcher only once
  if (is_first && parts.core->has_callback()) dispatcher_.add(parts.core);
  const LocalReader& added =
      ours_.readers.try_emplace(endpoint.id, context_, endpoint, std::move(parts)).first->second;
  look_after_vanilla(std::chrono::steady_clock::now());
  negotiation_.local_added(endpoint, added.core().type());
  dirty_ = true;
  reports_.inquire(std::chrono::steady_clock::now());
  announce(endpoint.id);
  if (is_first) misspelt_topics_.added(endpoint.id, std::chrono::steady_clock::now());
}

/// The destructor of a port waits until calls of its listener have returned. The agent must not wait for
/// such a call, because the callback in which a subscriber was destroyed may take long, or may itself wait
/// for the agent. So the reader is kept until its callback has returned.
void Reconciler::remove(EndpointId id) {
  negotiation_.local_removed(id);
  dirty_ = true;
  discovery_.withdraw(id);
  ours_.writers.erase(id);
  const auto reader = ours_.readers.find(id);
  if (reader == ours_.readers.end()) return;
  dispatcher_.remove(reader->second.core());
  reader->second.close();
  auto removed = ours_.readers.extract(reader);
  if (removed.mapped().core().is_called_back()) departing_.insert(std::move(removed));
}

void Reconciler::requirement_changed(EndpointId id) {
  const auto reader = ours_.readers.find(id);
  if (reader != ours_.readers.end()) dirty_ |= reader->second.requirement_changed();
}

/// Reports the assertion to other nodes at once, so that an assertion which the program makes in time also
/// arrives in time.
void Reconciler::program_asserts(EndpointId id) {
  const auto writer = ours_.writers.find(id);
  if (writer == ours_.writers.end()) return;
  const Time now = std::chrono::steady_clock::now();
  if (writer->second.watch_promises(now)) report({id}, now);
}

void Reconciler::take(const DiscoveryEvent& event, Time now) {
  if (const auto* const seen = std::get_if<EndpointSeen>(&event))
    dirty_ |= negotiation_.endpoint_seen(**seen);
  if (const auto* const departed = std::get_if<EndpointDeparted>(&event))
    dirty_ |= negotiation_.endpoint_departed(departed->id);
  if (const auto* const lost = std::get_if<EndpointLost>(&event))
    dirty_ |= negotiation_.endpoint_lost(lost->id, now);
  if (const auto* const request = std::get_if<Request>(&event))
    dirty_ |= negotiation_.request_received(*request);
  if (const auto* const report = std::get_if<NodeReport>(&event)) take_report(*report, now);
  if (std::holds_alternative<VanillaChanged>(event)) {
    look_after_vanilla(now);
    dirty_ = true;
  }
  if (const auto* const news = std::get_if<DiscoveryNews>(&event)) log_news(*news);
}

void Reconciler::take_report(const NodeReport& report, Time now) {
  for (const Progress& progress : report.progress) negotiation_.progressed(progress);
  reports_.received(report, now);
  for (auto& [id, reader] : ours_.readers) reader.asserted(report.living);
  if (!report.progress.empty()) look_at_arrivals(report.progress, now);
}

/// Of lines about refused messages, of which there may be a flood, only one per pause is logged.
void Reconciler::log_news(const DiscoveryNews& news) {
  using enum DiscoveryNews::Kind;
  if (news.kind == link_renewed) counts_.links_renewed.fetch_add(1, std::memory_order_relaxed);
  if (news.kind == malformed || news.kind == too_much) {
    std::atomic<std::uint64_t>& count = news.kind == malformed ? counts_.malformed : counts_.ignored;
    const std::uint64_t refused = count.fetch_add(news.times, std::memory_order_relaxed) + news.times;
    const auto now = std::chrono::steady_clock::now();
    if (now < next_complaint_) return;
    next_complaint_ = now + complaint_pause;
    log_.write(LogLevel::warning,
               "control traffic refused, " + std::to_string(refused) + " in all: " + news.text);
  } else {
    log_.write(news.kind == links_changed ? LogLevel::info : LogLevel::warning, "discovery: " + news.text);
  }
}

/// Sets up connections anew over which nothing arrives. `reported` is the progress of writers that has just
/// been reported.
void Reconciler::look_at_arrivals(const std::vector<Progress>& reported, Time now) {
  const bool held_up = now - held_up_at_ < held_up_for;
  for (auto& [id, reader] : ours_.readers) dirty_ |= reader.restart_stalled(reported, held_up, now);
}

bool Reconciler::look_after_vanilla(Time now) {
  const bool is_needed = observes_ || !ours_.writers.empty() || !ours_.readers.empty();
  return vanilla_.look(discovery_.vanilla(), is_needed, now);
}

void Reconciler::observe() {
  if (!std::exchange(observes_, true)) take(VanillaChanged{});
}

std::chrono::milliseconds Reconciler::tick(Time now) {
  look_after_memory(now);
  look_after_addresses(now);
  dirty_ |= look_after_vanilla(now);
  for (auto& [id, reader] : ours_.readers) reader.forget_what_was_in_flight(now);
  dirty_ |= negotiation_.tick(now);
  const auto publishers_of = [this](const auto& type) { return discovery_.publishers_of(type); };
  const auto all_publishers_of = [&](const auto& type) {
    std::vector<Discovery::KnownPublisher> publishers = publishers_of(type);
    std::ranges::move(vanilla_.publishers_of(type), std::back_inserter(publishers));
    return publishers;
  };
  for (const auto& sentences : {misspelt_topics_.look(negotiation_.table(), all_publishers_of, now),
                                second_servers_.look(negotiation_.table(), publishers_of, now)}) {
    for (const std::string& sentence : sentences) log_.write(LogLevel::warning, sentence);
  }
  look_after_endpoints(now);
  settle();
  const bool awaits_port = context_.memory != nullptr && context_.memory->awaits_answer();
  tick_pace_.note_waiting(look_after_connections(now) || awaits_port);
  watch_promises(now);
  reports_.inquire(now);
  discovery_looks_at_ = discovery_.look_after(now);
  if (!departing_.empty() || has_to_be_watched(negotiation_, ours_)) tick_pace_.stirred(now);
  reconcile();
  log_.tick(now);
  return pace(now);
}

void Reconciler::look_after_memory(Time now) {
  const TransportMonitor::MemoryChange change = transports_.look_at_memory(now);
  if (!change.any) return;
  dirty_ |= negotiation_.self_changed(transports_.self());
  // The memory of the ports is lost, or belongs to another daemon. In both cases the next daemon may be
  // asked at once.
  if (change.of_host) {
    attempts_.forget_daemon();
    for (auto& [id, writer] : ours_.writers) dirty_ |= writer.drop_memory();
    for (auto& [id, reader] : ours_.readers) reader.drop_memory();
    reconcile();  // from now on, the readers that were served in shared memory are served by UDP
  }
  if (change.of_state || change.of_host) transports_.log_memory();
  if (change.of_host || change.of_failure) announce_all();
  if (!change.of_host) return;
  for (auto& [id, reader] : ours_.readers) reader.send_request();
}

/// Announces the addresses of this node anew if its interfaces have changed.
void Reconciler::look_after_addresses(Time now) {
  const TransportMonitor::NetworkChange change = transports_.look_at_network(now);
  if (change == TransportMonitor::NetworkChange::none) return;
  dirty_ |= negotiation_.network_changed(transports_.addresses(), transports_.links());
  if (change == TransportMonitor::NetworkChange::addresses) announce_all();
}

void Reconciler::announce(EndpointId id) { discovery_.announce(*negotiation_.local(id)); }

void Reconciler::announce_all() {
  for (const auto& [id, writer] : ours_.writers) announce(id);
  for (const auto& [id, reader] : ours_.readers) announce(id);
}

void Reconciler::look_after_endpoints(Time now) {
  for (auto& [id, writer] : ours_.writers) {
    dirty_ |= writer.may_try_again(now);
    dirty_ |= writer.look_after_history();
    dirty_ |= writer.look_after_reach(now);
  }
  std::erase_if(departing_, [](const auto& item) { return !item.second.core().is_called_back(); });
  for (auto& [id, reader] : ours_.readers) {
    dirty_ |= reader.may_try_again(now);
    if (reader.ports().take_held_back()) reader.core().wake();
    if (CallbackMonitor* const callback = reader.callback()) {
      if (callback->is_in_long_callback()) held_up_at_ = now;
      log_long_waits(reader, callback->look(now));
    }
  }
}

void Reconciler::log_long_waits(const LocalReader& reader, const CallbackMonitor::LongWaits& waits) {
  constexpr auto text_of = [](Time::duration time) {
    return std::to_string(std::chrono::round<std::chrono::milliseconds>(time).count()) + " ms";
  };
  const auto topic_of = [](const LocalReader& one) { return text_of_topic(one.core().spec().topic, 0); };
  if (waits.of_receiver) {
    log_.write(LogLevel::warning, topic_of(reader) + ": its callback has run for " +
                                      text_of(*waits.of_receiver) + " on the thread that receives by UDP, " +
                                      "which receives nothing meanwhile; " + remedy_of_long_callbacks);
  }
  if (!waits.of_sample) return;
  const auto in_turn = std::ranges::find_if(
      ours_.readers, [this](const auto& item) { return dispatcher_.is_at(item.second.core()); });
  const std::string whose =
      in_turn == ours_.readers.end() ? "" : ", at present that of " + topic_of(in_turn->second);
  log_.write(LogLevel::warning, topic_of(reader) + ": a sample has waited for its callback for " +
                                    text_of(*waits.of_sample) +
                                    ", since the callbacks of a node run one after the other" + whose + "; " +
                                    remedy_of_long_callbacks);
}

/// Returns true if some reader still waits for its connection in shared memory. Notes whether samples are
/// sent or received in shared memory.
bool Reconciler::look_after_connections(Time now) {
  bool waiting = false;
  std::uint64_t samples = 0;
  for (auto& [id, reader] : ours_.readers) {
    const LocalReader::Connections connections = reader.look_after_connections();
    dirty_ |= connections.changed;
    waiting |= connections.waiting;
    samples += connections.arrivals;
  }
  for (const auto& [id, writer] : ours_.writers) samples += writer.sent_in_memory();
  tick_pace_.note_traffic(samples, now);
  return waiting;
}

void Reconciler::watch_promises(Time now) {
  std::vector<EndpointId> living;
  for (auto& [id, writer] : ours_.writers) {
    if (writer.watch_promises(now)) living.push_back(id);
  }
  if (!living.empty() || reports_.is_due(now)) report(std::move(living), now);
  for (auto& [id, reader] : ours_.readers) reader.watch_promises(now);
}

void Reconciler::report(std::vector<EndpointId> living, Time now) {
  const bool is_due = reports_.is_due(now);
  if (is_due) look_at_arrivals({}, now);
  NodeReport report = is_due ? reports_.take(now) : NodeReport{};
  report.living = std::move(living);
  if (report.empty()) return;
  discovery_.report(report);
  take_report(report, now);  // needed also by the readers of this node
}

/// Returns the time until the next tick: the time that tick_pace_ gives, or less if a transport, discovery,
/// a deadline or a lease has to be checked earlier.
std::chrono::milliseconds Reconciler::pace(Time now) const {
  std::chrono::nanoseconds pace = tick_pace_.next(now);
  for (const Time next : {transports_.next_look(now), discovery_looks_at_, vanilla_.next_look()}) {
    if (next - now < pace) pace = std::chrono::ceil<std::chrono::milliseconds>(next - now);
  }
  for (const auto& [id, writer] : ours_.writers) pace = std::min(pace, writer.pace().value_or(pace));
  for (const auto& [id, reader] : ours_.readers) pace = reader.pace(pace);
  return std::max(std::chrono::duration_cast<std::chrono::milliseconds>(pace), tick_shortest);
}

std::chrono::milliseconds Reconciler::reconcile() {
  const Time now = std::chrono::steady_clock::now();
  settle();
  for (auto& [id, writer] : ours_.writers) writer.report_events();
  for (auto& [id, reader] : ours_.readers) reader.report_events();
  return pace(now);
}

/// Brings the endpoints to the desired states. Repeats this until nothing changes any more, because new
/// connections of this node's readers may change the states of its writers.
void Reconciler::settle() {
  if (dirty_) tick_pace_.stirred(std::chrono::steady_clock::now());
  while (std::exchange(dirty_, false)) {
    vanilla_.forget_endpoints();
    std::size_t unattached = 0;
    for (const auto& [id, reader] : ours_.readers) unattached += reader.unattached();
    for (auto& [id, writer] : ours_.writers) writer.reconcile();
    for (auto& [id, reader] : ours_.readers) reader.reconcile(unattached);
    look_after_connections(std::chrono::steady_clock::now());
    vanilla_.show_endpoints();
  }
}

}  // namespace sft::core
