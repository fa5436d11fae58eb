#include "core/node/reconciler.h"

#include <algorithm>
#include <utility>

#include "core/report/events.h"

namespace sft::core {

namespace {

constexpr std::chrono::milliseconds tick_quiet{50};
constexpr std::chrono::milliseconds look_at_addresses_every{200};  // costs one call while all stays
constexpr std::chrono::milliseconds tick_while_attaching{1};
constexpr std::chrono::milliseconds tick_shortest{1};
constexpr std::chrono::milliseconds reach_again_after{1000};
constexpr std::chrono::milliseconds asks_last_least{3000};
constexpr int hurried_ticks_max = 1000;  // a connection that takes longer is not worth the looking

}  // namespace

Reconciler::Reconciler(NodeId id, std::uint64_t network, Transport* shm, Transport* udp, Discovery& discovery,
                       Dispatcher& dispatcher, NodeLog& log)
    : id_(id),
      shm_(shm),
      udp_(udp),
      discovery_(discovery),
      dispatcher_(dispatcher),
      log_(log),
      outbox_(negotiation_, discovery, log),
      control_watch_(negotiation_, log),
      answers_(std::max(asks_last_least, 3 * discovery.life_signs().pause)) {
  self_.network = network;
  self_.shm_state = shm_ == nullptr ? "the node rules it out" : "starting";
  negotiation_.self_changed(self_);
  if (udp_ == nullptr) return;
  addresses_ = udp_->addresses();
  links_ = udp_->links();
  negotiation_.network_changed(addresses_, links_);
}

/// A newcomer is told at once that we live: before that it would not notice our end.
void Reconciler::endpoint_seen(const Endpoint& endpoint) {
  if (!negotiation_.knows(endpoint.node_id)) told_of_life_at_ = {};
  dirty_ |= negotiation_.endpoint_seen(endpoint);
  if (negotiation_.knows(endpoint.node_id)) heard_of(endpoint);
}

/// Of its node, by anything but that it lives, which is said otherwise.
void Reconciler::heard_of(const Endpoint& endpoint) {
  silence_.heard(endpoint.node_id, endpoint.life_lease, std::chrono::steady_clock::now());
  dirty_ |= negotiation_.node_returned(endpoint.node_id);
}

void Reconciler::endpoint_departed(EndpointId id) { dirty_ |= negotiation_.endpoint_departed(id); }

void Reconciler::endpoint_lost(EndpointId id) {
  dirty_ |= negotiation_.endpoint_lost(id, std::chrono::steady_clock::now());
}

void Reconciler::request_received(const Request& request) {
  if (const Endpoint* reader = negotiation_.known(request.reader)) heard_of(*reader);
  dirty_ |= negotiation_.request_received(request);
}

std::string Reconciler::shm_state() const {
  const std::scoped_lock lock(shm_state_mutex_);
  return shm_ == nullptr ? "the node rules it out" : shm_state_;
}

void Reconciler::add_writer(const Endpoint& endpoint, std::shared_ptr<PublisherCore> core) {
  const TypeSupport& type = core->type();
  writers_.insert_or_assign(endpoint.id,
                            Writer{.core = std::move(core),
                                   .shm = nullptr,
                                   .in_force = {},
                                   .watch = OfferWatch(endpoint.qos, std::chrono::steady_clock::now()),
                                   .history_sent = {},
                                   .told = {}});
  negotiation_.local_added(endpoint, type);
  dirty_ = true;
  announce(endpoint.id);
}

void Reconciler::add_reader(const Endpoint& endpoint, NewReader reader) {
  const TypeSupport& type = reader.core->type();
  if (reader.core->has_callback()) dispatcher_.add(reader.core);
  Reader& added = readers_[endpoint.id];
  added.core = std::move(reader.core);
  added.recorder = std::move(reader.recorder);
  added.udp = std::move(reader.udp);
  added.requested = endpoint.qos;
  added.accepted = AcceptedRequests({added.core->spec().requirement.mask, endpoint.request.min_period_us},
                                    endpoint.qos.reliability == Reliability::reliable);
  accept(added);
  negotiation_.local_added(endpoint, type);
  dirty_ = true;
  announce(endpoint.id);
}

void Reconciler::remove(EndpointId id) {
  negotiation_.local_removed(id);
  dirty_ = true;
  outbox_.withdraw(id);
  answers_.removed(id);
  writers_.erase(id);
  const auto reader = readers_.find(id);
  if (reader == readers_.end()) return;
  const SubscriberCore& core = *reader->second.core;
  dispatcher_.remove(core);
  reader->second.core->ports().set(TransportKind::udp, nullptr);
  reader->second.core->ports().set(TransportKind::shm, nullptr);
  if (core.is_called_back()) leaving_.push_back(std::move(reader->second));
  readers_.erase(reader);
}

/// Ports wait for the call of their listener to return, which the agent must not: the callback in which a
/// subscriber was destroyed may take long, or itself ask the agent for something.
void Reconciler::let_go_of_the_left() {
  std::erase_if(leaving_, [](const Reader& reader) { return !reader.core->is_called_back(); });
}

void Reconciler::announce(EndpointId id) { outbox_.announce(id, std::chrono::steady_clock::now()); }

void Reconciler::take_back_what_is_ours(Now now) {
  for (const EndpointId id : control_watch_.take_contested(now)) {
    announce(id);
    if (readers_.contains(id)) request_changed(id);
  }
}

void Reconciler::requirement_changed(EndpointId id) {
  const auto reader = readers_.find(id);
  if (reader == readers_.end()) return;
  const TypeSupport& type = reader->second.core->type();
  const FieldMask mask = type.closed(reader->second.recorder->required());
  if (!negotiation_.requirement_changed(id, mask)) return;
  asks_for(reader->second, {mask, reader->second.accepted.latest().min_period_us});
  request_changed(id);
}

void Reconciler::rate_changed(EndpointId id) {
  const auto reader = readers_.find(id);
  if (reader == readers_.end()) return;
  reader->second.has_news = true;  // status() says it already
  const std::uint32_t min_period_us = reader->second.core->ports().min_period_us();
  if (!negotiation_.rate_changed(id, min_period_us)) return;
  asks_for(reader->second, {reader->second.accepted.latest().mask, min_period_us});
  request_changed(id);
}

void Reconciler::asks_for(Reader& reader, const Wanted& wanted) {
  dirty_ = true;
  reader.accepted.asks_for(wanted, std::chrono::steady_clock::now());
  accept(reader);
}

/// Samples under what was asked for before, and of writers that went, may be in flight.
void Reconciler::forget_what_was_in_flight(Now now) {
  for (auto& [id, reader] : readers_) {
    if (reader.accepted.look(now)) accept(reader);
    std::erase_if(reader.departed, [&](const auto& departed) {
      if (now - departed.second <= AcceptedRequests::in_flight_max) return false;
      reader.udp->disconnect(departed.first);
      return true;
    });
  }
}

void Reconciler::accept(Reader& reader) {
  if (reader.udp != nullptr) reader.udp->accept(reader.accepted.all());
}

void Reconciler::request_changed(EndpointId id) {
  const Request& request = negotiation_.local(id)->request;
  Reader& reader = readers_.at(id);
  SubscriberCore& core = *reader.core;
  reader.has_news = true;
  core.requests(FieldMask::from_words(core.type().leaves(), request.mask_words), request.sequence);
  outbox_.request(id, std::chrono::steady_clock::now());
}

std::chrono::milliseconds Reconciler::tick(Now now) {
  look_after_shm();
  look_after_udp(now);
  forget_what_was_in_flight(now);
  dirty_ |= negotiation_.tick(now);
  for (const NodeId node : silence_.take_lost(now)) dirty_ |= negotiation_.node_lost(node);
  dirty_ |= may_try_again(now);
  control_ignored_.store(negotiation_.ignored(), std::memory_order_relaxed);
  control_watch_.tell_of_refusals(now);
  outbox_.look(now);
  look_after_histories();
  look_after_reach(now);
  let_go_of_the_left();
  for (const auto& [id, reader] : readers_) reader.core->look_again();
  settle();
  hurried_ticks_ = look_after_connections() ? hurried_ticks_ + 1 : 0;
  look_for_callbacks_under_way(now);
  watch_promises(now);
  discovery_.look_after(now, negotiation_.misses_somebody());
  reconcile();
  log_.tick(now);
  const bool hurry = hurried_ticks_ > 0 && hurried_ticks_ <= hurried_ticks_max;
  return hurry ? tick_while_attaching : pace();
}

/// Until the next tick: no longer than a deadline or a lease can wait.
std::chrono::milliseconds Reconciler::pace() const {
  std::chrono::nanoseconds pace = tick_quiet;
  for (const auto& [id, writer] : writers_) pace = std::min(pace, writer.watch.pace().value_or(pace));
  for (const auto& [id, reader] : readers_) {
    for (const auto& [heard, watch] : reader.watched) pace = std::min(pace, watch.pace().value_or(pace));
  }
  return std::max(std::chrono::duration_cast<std::chrono::milliseconds>(pace), tick_shortest);
}

/// A late reader may change over to shared memory once it has what was sent by UDP: a tick after that has
/// left.
void Reconciler::look_after_histories() {
  for (auto& [id, writer] : writers_) {
    writer.core->expire_history();
    writer.core->give_history();
    if (!writer.in_force || !writer.in_force->history_owed) continue;
    const std::set<EndpointId> before = std::exchange(writer.history_sent, {});
    for (const Route& route : writer.in_force->udp) {
      if (route.history == 0 || !writer.core->history_sent(route.reader)) continue;
      writer.history_sent.insert(route.reader);
      if (before.contains(route.reader)) dirty_ |= negotiation_.history_given(id, route.reader);
    }
  }
}

void Reconciler::look_after_shm() {
  if (shm_ == nullptr) return;
  Self self = self_;
  const Availability availability = shm_->poll(std::chrono::steady_clock::now());
  const bool ready = availability == Availability::ready;
  self.host = ready ? shm_->host_token() : HostToken{};
  self.shm_state = shm_->description();
  self.may_write_shm = shm_->may_write();
  if (self == self_) return;
  const bool new_host = self.host != self_.host;
  const bool new_state = self.shm_state != self_.shm_state;
  self_ = self;
  shm_ready_.store(ready);
  {
    const std::scoped_lock lock(shm_state_mutex_);
    shm_state_ = self.shm_state;
  }
  dirty_ |= negotiation_.self_changed(self_);
  if (new_host) {
    drop_shm_ports();
    reconcile();  // first: who was served in memory is served by UDP from here on
  }
  if (new_state || new_host) tell_of_shm(availability);
  if (!new_host) return;
  for (const auto& [id, writer] : writers_) announce(id);
  for (const auto& [id, reader] : readers_) {
    announce(id);
    request_changed(id);
  }
}

/// Each attempt after one that failed is no news, only what comes of it. A program that is to start the
/// daemon and cannot is set up wrongly.
void Reconciler::tell_of_shm(Availability availability) {
  if (availability == Availability::starting && !shm_why_not_.empty()) return;
  if (availability == Availability::unavailable && self_.shm_state == shm_why_not_) return;
  shm_why_not_ = availability == Availability::unavailable ? self_.shm_state : "";
  const bool not_started = shm_why_not_.find("could not be started") != std::string::npos;
  const bool warns = not_started && !std::exchange(shm_warned_, true);
  log_.write(warns ? LogLevel::warning : LogLevel::info, "shared memory: " + self_.shm_state);
}

/// A transport that the system has stopped cannot be mended from within; status() says so from here on.
void Reconciler::look_after_udp(Now now) {
  if (udp_ == nullptr || udp_failed_) return;
  if (udp_->poll(now) == Availability::ready) return look_after_addresses(now);
  udp_failed_ = true;
  log_.write(LogLevel::error, "UDP: " + udp_->description());
}

/// Interfaces come and go: where we are reached then is announced anew.
void Reconciler::look_after_addresses(Now now) {
  if (now < next_look_at_addresses_) return;
  next_look_at_addresses_ = now + look_at_addresses_every;
  if (!udp_->network_changed()) return;
  std::vector<UdpAddress> addresses = udp_->addresses();
  std::vector<Link> links = udp_->links();
  const bool moved = addresses != addresses_;
  if (!moved && links == links_) return;
  dirty_ |= negotiation_.network_changed(addresses, links);
  addresses_ = std::move(addresses);
  links_ = std::move(links);
  if (!moved) return;
  for (const auto& [id, writer] : writers_) announce(id);
  for (const auto& [id, reader] : readers_) announce(id);
}

/// The memory that they were in is gone, or another daemon's, which is to be asked at once.
void Reconciler::drop_shm_ports() {
  asking_daemon_ = {};
  for (auto& [id, writer] : writers_) {
    writer.opening_shm = {};
    for (const auto& [reader, retry] : std::exchange(writer.reaching, {}))
      dirty_ |= negotiation_.reach_changed(id, reader, {});
    if (writer.shm == nullptr) continue;
    writer.shm.reset();
    writer.in_force.reset();
  }
  for (auto& [id, reader] : readers_) {
    reader.core->ports().set(TransportKind::shm, nullptr);
    reader.shm.reset();
    for (auto& [writer, hearing] : reader.heard) hearing.shm = false;
    for (auto& [writer, connecting] : reader.connecting) connecting.shm = {};
  }
}

void Reconciler::reconcile() {
  take_back_what_is_ours(std::chrono::steady_clock::now());
  settle();
  tell_what_happened();
}

/// Until nothing changes any more: what our readers are connected to is news to our own writers.
void Reconciler::settle() {
  while (std::exchange(dirty_, false)) {
    apply_desired_states();
    look_after_connections();
  }
}

/// Of those only of which something can have happened: states are copied to be compared.
void Reconciler::tell_what_happened() {
  for (auto& [id, writer] : writers_) {
    writer.has_news |= writer.core->diverted() != writer.told.diverted;
    if (std::exchange(writer.has_news, false)) tell(writer);
  }
  for (auto& [id, reader] : readers_) {
    const std::uint64_t losses = reader.core->ports().losses();
    reader.has_news |= std::exchange(reader.losses_told, losses) != losses;
    reader.has_news |= reader.core->ports().held_too_many() != reader.told.held_too_many;
    if (std::exchange(reader.has_news, false)) tell(reader);
  }
}

std::vector<Event> Reconciler::differences(const Writer& writer, const PublisherStatus& now) {
  return events_between(writer.told, now, writer.core->type());
}

std::vector<Event> Reconciler::differences(const Reader& reader, const SubscriberStatus& now) {
  return events_between(reader.told, now, reader.core->type(), reader.requested.reliability);
}

/// Events are what differs between the states that users could have polled.
template <class Member>
void Reconciler::tell(Member& member) {
  auto& core = *member.core;
  if (!core.events().wanted() && !log_.wants(LogLevel::warning)) return;
  auto now = core.status();
  const auto events = differences(member, now);
  member.told = std::move(now);
  for (const Event& event : events) {
    log_.write(core.spec().topic, event);
    core.events().tell(event);
  }
}

void Reconciler::apply_desired_states() {
  unattached_ = count_unattached();
  for (auto& [id, writer] : writers_) reconcile_writer(id, writer);
  for (auto& [id, reader] : readers_) reconcile_reader(id, reader);
}

void Reconciler::reconcile_writer(EndpointId id, Writer& writer) {
  Serving wanted = negotiation_.serving(id);
  if (!wanted.shm_port || writer.shm != nullptr) {
    writer.opening_shm = {};
  } else {
    try_shm(writer.opening_shm, [&]() -> Result<void> {
      auto port = shm_->open_writer(
          {id, &writer.core->type(), writer.core->retains(), writer.core->spec().max_blocking});
      if (!port) return tl::unexpected(port.error());
      writer.shm = std::move(*port);
      writer.in_force.reset();
      return {};
    });
  }
  wanted = reachable(id, writer, std::move(wanted));
  if (writer.in_force == wanted) return;
  const bool as_before = writer.in_force && writer.in_force->serves_like(wanted);
  writer.in_force = wanted;
  writer.has_news = true;
  as_before ? writer.core->show(wanted.readers) : writer.core->serve(wanted, writer.shm);
}

/// Before a reader is served in shared memory it is made sure that it can be told of samples there.
Serving Reconciler::reachable(EndpointId id, Writer& writer, Serving wanted) {
  std::erase_if(writer.reaching, [&](const auto& item) {
    const auto is_it = [&](const Route& route) { return route.reader == item.first; };
    if (std::ranges::any_of(wanted.shm, is_it) || std::ranges::any_of(wanted.unreached, is_it)) return false;
    negotiation_.reach_changed(id, item.first, {});  // it is not attached any more
    return true;
  });
  if (writer.shm == nullptr) return wanted;
  const auto served_before = [&](const Route& route) {
    return writer.in_force && std::ranges::any_of(writer.in_force->shm, [&](const Route& before) {
             return before.reader == route.reader && before.destination == route.destination;
           });
  };
  bool changed = false;
  for (const Route& route : wanted.shm) {
    if (served_before(route)) continue;
    const std::string why_not = writer.shm->why_unreachable(route);
    if (why_not.empty()) {
      writer.reaching.erase(route.reader);
      continue;
    }
    changed |= negotiation_.reach_changed(id, route.reader, why_not);
    if (writer.reaching[route.reader].failed(why_not, std::chrono::steady_clock::now(), reach_again_after)) {
      const Endpoint* reader = negotiation_.known(route.reader);
      log_.write(LogLevel::warning, writer.core->spec().topic + ": the subscriber of node '" +
                                        (reader == nullptr ? "" : reader->node) +
                                        "' is not served in shared memory: " + why_not);
    }
  }
  return changed ? negotiation_.serving(id) : wanted;
}

/// A reader that could not be told of samples is asked for again: what stood in the way may be gone.
void Reconciler::look_after_reach(Now now) {
  for (auto& [id, writer] : writers_) {
    for (const auto& [reader, retry] : writer.reaching) {
      if (retry.due_again(now)) dirty_ |= negotiation_.reach_changed(id, reader, {});
    }
  }
}

}  // namespace sft::core
