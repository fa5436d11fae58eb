#include "core/node_core.h"

#include <algorithm>
#include <numeric>
#include <thread>
#include <utility>

#include "core/network_id.h"
#include "core/random_id.h"

namespace sft::core {

namespace {

constexpr std::size_t accepted_masks_max = 16;
constexpr std::chrono::seconds in_flight_max{2};         // what was sent longer ago does not come any more
constexpr std::chrono::milliseconds shm_pause_min{500};  // after the daemon did not do what was asked for
constexpr std::chrono::milliseconds shm_pause_max{10'000};
constexpr std::chrono::milliseconds tick_quiet{50};
constexpr std::chrono::milliseconds tick_while_attaching{1};
constexpr int hurried_ticks_max = 1000;  // a connection that takes longer is not worth the looking

}  // namespace

Result<std::shared_ptr<NodeCore>> NodeCore::open(const NodeOptions& options, Parts parts) {
  std::shared_ptr<NodeCore> node(new NodeCore(options, std::move(parts)), &NodeCore::dispose);
  const DiscoveryOptions discovery{.domain = options.domain.value_or(0),
                                   .user_config = options.cyclonedds_config.value_or("")};
  auto opened = Discovery::open(discovery, *node);
  if (!opened) return tl::unexpected(opened.error());
  node->discovery_ = std::move(*opened);
  NodeCore* const self = node.get();
  node->agent_.start("sft-agent " + options.name,
                     {.tick = [self] { return self->tick(); }, .idle = [self] { self->reconcile(); }});
  return node;
}

NodeCore::NodeCore(const NodeOptions& options, Parts parts)
    : options_(options),
      network_(network_id()),
      shm_(std::move(parts.shm)),
      udp_(std::move(parts.udp)),
      heap_(BufferPool::make(options.udp.memory_limit_bytes)),
      bells_(DoorbellPage::create()),
      free_slots_(DoorbellPage::slots - 1),
      dispatcher_(bells_->at(0), "sft-call " + options.name) {
  std::iota(free_slots_.rbegin(), free_slots_.rend(), 1U);
  self_.network = network_;
  self_.shm_state = shm_ == nullptr ? "the node rules it out" : "starting";
  negotiation_.self_changed(self_);
}

NodeCore::~NodeCore() {
  agent_.stop();  // runs the endpoints' withdrawals first, which were posted before the last handle went
  discovery_.reset();
}

/// The last handle may go within a callback, on a thread that the destructor would wait for.
void NodeCore::dispose(NodeCore* node) {
  const bool own_thread = SubscriberCore::in_callback() || node->agent_.is_current_thread() ||
                          node->dispatcher_.is_current_thread();
  if (own_thread) {
    std::thread([node] { delete node; }).detach();
  } else {
    delete node;
  }
}

Result<std::uint32_t> NodeCore::take_slot() {
  const std::scoped_lock lock(slots_mutex_);
  if (free_slots_.empty())
    return fail(Errc::limit_exceeded, "a node has at most 1023 subscribers without callback");
  const std::uint32_t slot = free_slots_.back();
  free_slots_.pop_back();
  return slot;
}

void NodeCore::give_slot_back(std::uint32_t slot) {
  if (slot == 0) return;
  const std::scoped_lock lock(slots_mutex_);
  free_slots_.push_back(slot);
}

bool NodeCore::may_use(TransportKind kind, TransportChoice choice) const {
  const TransportChoice other = kind == TransportKind::shm ? TransportChoice::udp : TransportChoice::shm;
  const Transport* transport = kind == TransportKind::shm ? shm_.get() : udp_.get();
  return transport != nullptr && choice != other && options_.transport != other;
}

Result<void> NodeCore::check_endpoint(std::string_view topic, const TypeSupport& type,
                                      TransportChoice choice) const {
  if (topic.empty() || topic.size() > name_bytes_max || type.name().size() > name_bytes_max) {
    return fail(Errc::invalid_argument,
                "the name of a topic has 1 to 255 characters: '" + std::string(topic) + "'");
  }
  if (type.leaves() > mask_words_max * 64) {
    return fail(Errc::limit_exceeded, std::string(type.name()) + " has more than 4096 fields");
  }
  if (!may_use(TransportKind::shm, choice) && !may_use(TransportKind::udp, choice)) {
    return fail(Errc::invalid_argument, "topic '" + std::string(topic) +
                                            "': the endpoint's choice of transport contradicts the node's");
  }
  return {};
}

Endpoint NodeCore::new_endpoint(Role role, std::string_view topic, const TypeSupport& type,
                                TransportChoice choice) const {
  Endpoint endpoint;
  endpoint.id = random_id();
  endpoint.role = role;
  endpoint.node = options_.name.substr(0, name_bytes_max);
  endpoint.topic = topic;
  endpoint.type_name = type.name();
  endpoint.type_hash = type.hash();
  endpoint.may_use_shm = may_use(TransportKind::shm, choice);
  endpoint.may_use_udp = may_use(TransportKind::udp, choice);
  if (endpoint.may_use_udp) endpoint.addresses = udp_->addresses();
  return endpoint;
}

Result<untyped::Publisher> NodeCore::open_publisher(const std::shared_ptr<NodeCore>& self,
                                                    std::string_view topic, const TypeSupport& type,
                                                    const PublisherOptions& options) {
  if (auto ok = check_endpoint(topic, type, options.transport); !ok) return tl::unexpected(ok.error());
  Endpoint endpoint = new_endpoint(Role::writer, topic, type, options.transport);
  endpoint.max_sample_bytes = options.max_sample_bytes;
  std::shared_ptr<WriterPort> udp;
  if (endpoint.may_use_udp) {
    auto port = udp_->open_writer({endpoint.id, &type, options.max_sample_bytes});
    if (!port) return tl::unexpected(port.error());
    udp = std::move(*port);
  }
  auto core = std::make_shared<PublisherCore>(
      PublisherCore::Spec{endpoint.id, endpoint.topic, &type, options.max_sample_bytes,
                          options.on_readers_changed},
      heap_, std::move(udp));
  agent_.post([this, endpoint, core] { add_writer(endpoint, core); });
  // The handle withdraws the endpoint; the agent lets go of the rest.
  std::shared_ptr<PublisherCore> handle(core.get(), [self, core, id = endpoint.id](PublisherCore*) {
    self->agent_.post([node = self.get(), id] { node->remove(id); });
  });
  return untyped::Publisher(std::move(handle));
}

Result<untyped::Subscriber> NodeCore::open_subscriber(const std::shared_ptr<NodeCore>& self,
                                                      std::string_view topic, const TypeSupport& type,
                                                      untyped::Requirement requirement,
                                                      const SubscriberOptions& options,
                                                      untyped::Callback callback) {
  if (auto ok = check_endpoint(topic, type, options.transport); !ok) return tl::unexpected(ok.error());
  const Result<std::uint32_t> slot = callback ? Result<std::uint32_t>(0) : take_slot();
  if (!slot) return tl::unexpected(slot.error());
  Endpoint endpoint = new_endpoint(Role::reader, topic, type, options.transport);
  endpoint.recorded = requirement.recorded;
  endpoint.doorbell = {bells_->id(), *slot};
  // Without a shared page nobody else could ring.
  endpoint.may_use_shm = endpoint.may_use_shm && bells_->id() != 0;
  requirement.mask = type.closed(requirement.mask);
  endpoint.request.reader = endpoint.id;
  endpoint.request.sequence = 1;
  endpoint.request.mask_words = requirement.mask.to_words();
  Reader reader;
  if (requirement.recorded) {
    reader.recorder = Recorder::make(type.leaves(), options.recording, [this, id = endpoint.id] {
      agent_.post([this, id] { requirement_changed(id); });
    });
  }
  reader.accepted = {{requirement.mask}};
  reader.core = std::make_shared<SubscriberCore>(
      SubscriberCore::Spec{endpoint.id, endpoint.topic, &type, requirement, options, std::move(callback)},
      bells_->at(*slot), reader.recorder);
  if (endpoint.may_use_udp) {
    auto port = udp_->open_reader({endpoint.id, &type, options.depth, reader.core.get(), endpoint.doorbell});
    if (!port) return tl::unexpected(port.error());
    reader.udp = std::move(*port);
    accept(reader);
    reader.core->set_port(TransportKind::udp, reader.udp);
  }
  const std::shared_ptr<SubscriberCore> core = reader.core;
  const std::shared_ptr<Recorder> recorder = reader.recorder;
  agent_.post(
      [this, endpoint, reader = std::move(reader)]() mutable { add_reader(endpoint, std::move(reader)); });
  std::shared_ptr<SubscriberCore> handle(core.get(),
                                         [self, core, recorder, id = endpoint.id](SubscriberCore*) {
                                           core->close();
                                           if (recorder != nullptr) recorder->detach();
                                           self->agent_.post([node = self.get(), id] { node->remove(id); });
                                         });
  return untyped::Subscriber(std::move(handle));
}

void NodeCore::add_writer(const Endpoint& endpoint, std::shared_ptr<PublisherCore> core) {
  const TypeSupport& type = core->type();
  writers_[endpoint.id].core = std::move(core);
  negotiation_.local_added(endpoint, type);
  dirty_ = true;
  announce(endpoint.id);
}

void NodeCore::add_reader(const Endpoint& endpoint, Reader reader) {
  const TypeSupport& type = reader.core->type();
  if (reader.core->has_callback() && endpoint.may_use_shm) dispatcher_.add(reader.core);
  readers_[endpoint.id] = std::move(reader);
  negotiation_.local_added(endpoint, type);
  dirty_ = true;
  announce(endpoint.id);
}

void NodeCore::remove(EndpointId id) {
  if (const Endpoint* endpoint = negotiation_.local(id);
      endpoint != nullptr && endpoint->role == Role::reader) {
    give_slot_back(endpoint->doorbell.slot);
  }
  negotiation_.local_removed(id);
  dirty_ = true;
  discovery_->withdraw(id);
  writers_.erase(id);
  const auto reader = readers_.find(id);
  if (reader == readers_.end()) return;
  dispatcher_.remove(*reader->second.core);
  reader->second.core->set_port(TransportKind::udp, nullptr);
  reader->second.core->set_port(TransportKind::shm, nullptr);
  readers_.erase(reader);
}

void NodeCore::announce(EndpointId id) {
  const Endpoint* endpoint = negotiation_.local(id);
  if (endpoint == nullptr) return;
  if (const Result<void> sent = discovery_->announce(*endpoint); !sent)
    log(LogLevel::warning, sent.error().message);
}

void NodeCore::endpoint_seen(Endpoint endpoint) {
  agent_.post([this, endpoint = std::move(endpoint)] { dirty_ |= negotiation_.endpoint_seen(endpoint); });
}

void NodeCore::endpoint_departed(EndpointId id) {
  agent_.post([this, id] { dirty_ |= negotiation_.endpoint_departed(id); });
}

void NodeCore::endpoint_lost(EndpointId id) {
  agent_.post([this, id] { dirty_ |= negotiation_.endpoint_lost(id, std::chrono::steady_clock::now()); });
}

void NodeCore::request_received(Request request) {
  agent_.post([this, request = std::move(request)] { dirty_ |= negotiation_.request_received(request); });
}

void NodeCore::control_malformed(std::string why) {
  control_malformed_.fetch_add(1, std::memory_order_relaxed);
  log(LogLevel::warning, why);
}

void NodeCore::requirement_changed(EndpointId id) {
  const auto reader = readers_.find(id);
  if (reader == readers_.end()) return;
  const TypeSupport& type = reader->second.core->type();
  const FieldMask mask = type.closed(reader->second.recorder->required());
  if (!negotiation_.requirement_changed(id, mask)) return;
  dirty_ = true;
  std::vector<AcceptedMask>& accepted = reader->second.accepted;
  accepted.back().replaced_at = std::chrono::steady_clock::now();
  std::erase_if(accepted, [&](const AcceptedMask& a) { return a.mask == mask; });
  accepted.push_back({mask});
  if (accepted.size() > accepted_masks_max) accepted.erase(accepted.begin());
  accept(reader->second);
  request_changed(id);
}

/// Samples under what was asked for before, and of writers that went, may be in flight. For long such a mask
/// must not be accepted: another reader in this process may ask for just that, and its samples would be taken
/// for ours.
void NodeCore::forget_what_was_in_flight(Now now) {
  const auto is_over = [&](Now since) { return since != Now::max() && now - since > in_flight_max; };
  for (auto& [id, reader] : readers_) {
    const auto is_old = [&](const AcceptedMask& a) { return is_over(a.replaced_at); };
    if (std::erase_if(reader.accepted, is_old) != 0) accept(reader);
    std::erase_if(reader.departed, [&](const auto& departed) {
      if (!is_over(departed.second)) return false;
      reader.udp->disconnect(departed.first);
      return true;
    });
  }
}

void NodeCore::accept(Reader& reader) {
  if (reader.udp == nullptr) return;
  std::vector<FieldMask> masks;
  for (const AcceptedMask& accepted : reader.accepted) masks.push_back(accepted.mask);
  reader.udp->accept_masks(std::move(masks));
}

void NodeCore::request_changed(EndpointId id) {
  const Request& request = negotiation_.local(id)->request;
  SubscriberCore& core = *readers_.at(id).core;
  core.requests(FieldMask::from_words(core.type().leaves(), request.mask_words), request.sequence);
  if (const Result<void> sent = discovery_->send(request); !sent) {
    log(LogLevel::warning, sent.error().message);
  }
}

std::chrono::milliseconds NodeCore::tick() {
  const auto now = std::chrono::steady_clock::now();
  look_after_shm();
  look_after_udp(now);
  forget_what_was_in_flight(now);
  dirty_ |= negotiation_.tick(now) || (shm_pause_.count() != 0 && now >= next_shm_attempt_);
  control_ignored_.store(negotiation_.ignored(), std::memory_order_relaxed);
  reconcile();
  hurried_ticks_ = look_after_connections() ? hurried_ticks_ + 1 : 0;
  reconcile();
  const bool hurry = hurried_ticks_ > 0 && hurried_ticks_ <= hurried_ticks_max;
  return hurry ? tick_while_attaching : tick_quiet;
}

void NodeCore::look_after_shm() {
  if (shm_ == nullptr) return;
  Self self = self_;
  const bool ready = shm_->poll(std::chrono::steady_clock::now()) == Availability::ready;
  self.host = ready ? shm_->host_token() : HostToken{};
  self.shm_state = shm_->description();
  if (self == self_) return;
  const bool new_host = self.host != self_.host;
  self_ = self;
  shm_ready_.store(ready);
  {
    const std::scoped_lock lock(shm_state_mutex_);
    shm_state_ = self.shm_state;
  }
  dirty_ |= negotiation_.self_changed(self_);
  if (!new_host) return;
  drop_shm_ports();
  shm_pause_ = {};
  next_shm_attempt_ = {};
  reconcile();  // first: who was served in memory is served by UDP from here on
  log(LogLevel::info, "shared memory: " + self_.shm_state);
  for (const auto& [id, writer] : writers_) announce(id);
  for (const auto& [id, reader] : readers_) {
    announce(id);
    request_changed(id);
  }
}

/// A transport that the system has stopped cannot be mended from within; status() says so from here on.
void NodeCore::look_after_udp(Now now) {
  if (udp_ == nullptr || udp_failed_ || udp_->poll(now) == Availability::ready) return;
  udp_failed_ = true;
  log(LogLevel::error, "UDP: " + udp_->description());
}

/// The memory that they were in is gone, or another daemon's.
void NodeCore::drop_shm_ports() {
  for (auto& [id, writer] : writers_) {
    if (writer.shm == nullptr) continue;
    writer.shm.reset();
    writer.in_force.reset();
  }
  for (auto& [id, reader] : readers_) {
    reader.core->set_port(TransportKind::shm, nullptr);
    reader.shm.reset();
    for (auto& [writer, hearing] : reader.heard) hearing.shm = false;
  }
}

/// Tells writers which of our readers hear them by now. Whether some reader still waits for its connection in
/// shared memory.
bool NodeCore::look_after_connections() {
  bool waiting = false;
  for (auto& [id, reader] : readers_) {
    bool changed = false;
    for (const auto& [writer, hearing] : reader.heard) {
      const bool listening = hearing.udp && reader.udp->connected(writer);
      const bool attached = hearing.shm && reader.shm != nullptr && reader.shm->connected(writer);
      changed |= negotiation_.connection_changed(id, writer, TransportKind::udp, listening);
      changed |= negotiation_.connection_changed(id, writer, TransportKind::shm, attached);
      waiting |= hearing.shm && !attached;
    }
    if (changed) request_changed(id);
    dirty_ |= changed;
  }
  return waiting;
}

/// Opens something in shared memory, unless that failed a moment ago: a daemon that does not answer costs its
/// deadline each time, during which the agent does nothing else.
template <class Open>
bool NodeCore::try_shm(Open open) {
  const Now now = std::chrono::steady_clock::now();
  if (now < next_shm_attempt_) return false;
  const Result<void> opened = open();
  if (opened) {
    shm_pause_ = {};
    return true;
  }
  shm_pause_ = std::clamp(shm_pause_ * 2, shm_pause_min, shm_pause_max);
  next_shm_attempt_ = std::chrono::steady_clock::now() + shm_pause_;
  log(LogLevel::warning, opened.error().message);
  return false;
}

/// Until nothing changes any more: what our readers are connected to is news to our own writers.
void NodeCore::reconcile() {
  while (std::exchange(dirty_, false)) {
    apply_desired_states();
    look_after_connections();
  }
}

void NodeCore::apply_desired_states() {
  for (auto& [id, writer] : writers_) reconcile_writer(id, writer);
  for (auto& [id, reader] : readers_) reconcile_reader(id, reader);
}

void NodeCore::reconcile_writer(EndpointId id, Writer& writer) {
  const Serving wanted = negotiation_.serving(id);
  if (wanted.shm_port && writer.shm == nullptr) {
    try_shm([&]() -> Result<void> {
      auto port = shm_->open_writer({id, &writer.core->type(), negotiation_.local(id)->max_sample_bytes});
      if (!port) return tl::unexpected(port.error());
      writer.shm = std::move(*port);
      writer.in_force.reset();
      return {};
    });
  }
  if (writer.in_force == wanted) return;
  writer.in_force = wanted;
  writer.core->serve(wanted, writer.shm);
}

void NodeCore::reconcile_reader(EndpointId id, Reader& reader) {
  const std::vector<Hearing> wanted = negotiation_.hearing(id);
  std::map<EndpointId, Hearing> heard;
  for (const Hearing& hearing : wanted) {
    const auto before = reader.heard.find(hearing.source.writer);
    const bool known = before != reader.heard.end();
    heard[hearing.source.writer] = connect(id, reader, hearing, known ? before->second : Hearing{});
  }
  for (const auto& [writer, before] : reader.heard) {
    if (heard.contains(writer)) continue;
    if (before.udp) reader.departed[writer] = std::chrono::steady_clock::now();
    if (before.shm && reader.shm != nullptr) reader.shm->disconnect(writer);
    negotiation_.connection_changed(id, writer, TransportKind::udp, false);
    negotiation_.connection_changed(id, writer, TransportKind::shm, false);
  }
  reader.heard = std::move(heard);
  reader.core->hears(wanted);
}

/// Connects to and disconnects from one writer as wanted; returns what is in force then.
Hearing NodeCore::connect(EndpointId id, Reader& reader, const Hearing& wanted, const Hearing& before) {
  Hearing now = wanted;
  const EndpointId writer = wanted.source.writer;
  reader.departed.erase(writer);
  if (wanted.udp != before.udp) {
    if (!wanted.udp) {
      reader.udp->disconnect(writer);
    } else if (const Result<void> ok = reader.udp->connect(wanted.source); !ok) {
      now.udp = false;
      log(LogLevel::warning, ok.error().message);
    }
  }
  if (wanted.shm != before.shm) {
    if (!wanted.shm) {
      if (reader.shm != nullptr) reader.shm->disconnect(writer);
    } else {
      now.shm = try_shm([&] { return connect_shm(id, reader, wanted.source); });
    }
  }
  return now;
}

Result<void> NodeCore::connect_shm(EndpointId id, Reader& reader, const Source& source) {
  if (reader.shm == nullptr) {
    auto port = shm_->open_reader({id, &reader.core->type(), reader.core->spec().options.depth,
                                   reader.core.get(), negotiation_.local(id)->doorbell});
    if (!port) return tl::unexpected(port.error());
    reader.shm = std::move(*port);
    reader.core->set_port(TransportKind::shm, reader.shm);
  }
  return reader.shm->connect(source);
}

NodeStatus NodeCore::status() const {
  NodeStatus status;
  status.udp = udp_ == nullptr ? "the node rules it out" : udp_->description();
  status.shm_ready = shm_ready_.load();
  if (udp_ != nullptr) {
    const Transport::Counters counters = udp_->counters();
    status.datagrams_malformed = counters.malformed;
    status.datagrams_unknown = counters.unknown;
    status.samples_incomplete = counters.incomplete;
    status.over_limit = counters.over_limit;
  }
  status.control_malformed = control_malformed_.load(std::memory_order_relaxed);
  status.control_ignored = control_ignored_.load(std::memory_order_relaxed);
  const std::scoped_lock lock(shm_state_mutex_);
  status.shm = shm_ == nullptr ? "the node rules it out" : shm_state_;
  return status;
}

void NodeCore::log(LogLevel level, const std::string& text) const {
  if (options_.log) options_.log(level, options_.name + ": " + text);
}

}  // namespace sft::core
