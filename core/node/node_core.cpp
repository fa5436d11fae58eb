#include "core/node/node_core.h"

#include <algorithm>
#include <functional>
#include <future>
#include <iterator>
#include <numeric>
#include <utility>

#include "core/control/described_type.h"
#include "core/control/names.h"
#include "core/node/topics.h"
#include "core/platform/clock.h"
#include "core/platform/network_id.h"
#include "core/platform/random_id.h"
#include "core/platform/thread.h"

namespace sft::core {

using namespace std::chrono_literals;

namespace {
constexpr std::uint32_t max_held_least = 2;   // one is held while the next is taken
constexpr std::uint32_t max_held_most = 256;  // iceoryx's limit
constexpr std::chrono::seconds complaint_pause{1};
constexpr std::chrono::seconds max_spin{1};  // of the thread that calls back: then it looks after the rest

// Doorbells that subscribers share, because one thread sleeps for all of them.
constexpr std::uint32_t dispatcher_slot = 0;
constexpr std::uint32_t poller_slot = 1;
constexpr std::uint32_t shared_slots = 2;
}  // namespace

Result<std::shared_ptr<NodeCore>> NodeCore::open(const NodeOptions& options, Parts parts) {
  const auto fault = options.name.empty() ? std::string_view() : fault_of_name(options.name);
  if (!fault.empty())
    return fail(Errc::invalid_argument,
                "the node's name " + in_quotes(options.name) + " " + std::string(fault));
  std::shared_ptr<NodeCore> node(new NodeCore(options, std::move(parts)), &NodeCore::dispose);
  const DiscoveryOptions discovery{.domain = options.domain.value_or(0),
                                   .settings = options.discovery,
                                   .user_config = options.cyclonedds_config.value_or(""),
                                   .threads = options.threads.discovery};
  auto opened = Discovery::open(discovery, *node);
  if (!opened) return tl::unexpected(opened.error());
  node->discovery_ = std::move(*opened);
  const Discovery::Configuration configuration = node->discovery_->configuration();
  for (const auto* texts : {&configuration.warnings, &configuration.remarks}) {
    for (const std::string& text : *texts) node->log_.write(LogLevel::warning, "discovery: " + text);
  }
  node->reconciler_ =
      std::make_unique<Reconciler>(node->id_, node->network_, node->shm_.get(), node->udp_.get(),
                                   *node->discovery_, node->dispatcher_, node->log_);
  Reconciler* const reconciler = node->reconciler_.get();
  const Agent::Duties duties{.tick = [reconciler] { return reconciler->tick(); },
                             .idle = [reconciler] { reconciler->reconcile(); }};
  const Result<void> started = node->agent_.start({"agent " + options.name, options.threads.agent}, duties);
  if (!started) return tl::unexpected(started.error());
  return node;
}

NodeCore::NodeCore(const NodeOptions& options, Parts parts)
    : options_(options),
      id_(random_id()),
      network_(network_id()),
      shm_(std::move(parts.shm)),
      udp_(std::move(parts.udp)),
      heap_(std::move(parts.heap)),
      bells_(DoorbellPage::create()),
      free_slots_(DoorbellPage::slots - shared_slots),
      log_(options.name, options.log_level, options.log),
      dispatcher_(bells_->at(dispatcher_slot), {"call " + options.name, options.threads.callbacks}),
      poller_(bells_->at(poller_slot), {"poll " + options.name, options.threads.callbacks}) {
  std::iota(free_slots_.rbegin(), free_slots_.rend(), shared_slots);
}

NodeCore::~NodeCore() {
  agent_.stop();  // runs the endpoints' withdrawals first, which were posted before the last handle went
  discovery_.reset();
}

/// The last handle may go within a callback, on a thread that the destructor would wait for.
void NodeCore::dispose(NodeCore* node) {
  if (is_forked_copy()) return;  // its threads are not there, and its sockets and files are the parent's
  const bool own_thread = SubscriberCore::in_callback() || node->agent_.is_current_thread() ||
                          node->dispatcher_.is_current_thread() || node->poller_.is_current_thread();
  if (!own_thread) {
    delete node;
  } else if (auto thread = start_thread("sft-close", [node] { delete node; })) {
    thread->detach();
  } else {
    node->agent_.post([node, why = thread.error().message] {
      node->log_.write(LogLevel::error, "the node stays open: " + why);
    });
  }
}

Result<std::uint32_t> NodeCore::slot_for(bool has_callback, bool pollable) {
  if (!has_callback && !pollable) return take_slot();
  if (has_callback && pollable) {
    return fail(Errc::invalid_argument,
                "a subscriber has a callback or a file descriptor: leave SubscriberOptions::pollable false");
  }
  const Result<void> started = (has_callback ? dispatcher_ : poller_).start();
  if (!started) return tl::unexpected(started.error());
  return has_callback ? dispatcher_slot : poller_slot;
}

Result<std::uint32_t> NodeCore::take_slot() {
  const std::scoped_lock lock(slots_mutex_);
  if (free_slots_.empty())
    return fail(Errc::limit_exceeded,
                "a node has at most 1022 subscribers with neither callback nor file descriptor");
  const std::uint32_t slot = free_slots_.back();
  free_slots_.pop_back();
  return slot;
}

void NodeCore::give_slot_back(std::uint32_t slot) {
  if (slot < shared_slots) return;
  const std::scoped_lock lock(slots_mutex_);
  free_slots_.push_back(slot);
}

bool NodeCore::may_use(TransportKind kind, TransportChoice choice) const {
  const TransportChoice other = kind == TransportKind::shm ? TransportChoice::udp : TransportChoice::shm;
  const Transport* transport = kind == TransportKind::shm ? shm_.get() : udp_.get();
  return transport != nullptr && choice != other && options_.transport != other;
}

Result<void> NodeCore::check_topic(std::string_view topic) {
  if (const auto fault = fault_of_topic(topic); !fault.empty())
    return fail(Errc::invalid_argument, "topic " + in_quotes(topic) + " " + std::string(fault));
  return {};
}

Result<void> NodeCore::check_endpoint(std::string_view topic, const TypeSupport& type,
                                      TransportChoice choice) const {
  if (Result<void> sound = check_topic(topic); !sound) return sound;
  if (const auto fault = fault_of_name(type.name()); !fault.empty())
    return fail(Errc::invalid_argument, "type name " + in_quotes(type.name()) + " " + std::string(fault));
  if (type.leaves() > mask_words_max * 64) {
    return fail(Errc::limit_exceeded, std::string(type.name()) + " has more than 4096 fields");
  }
  if (!may_use(TransportKind::shm, choice) && !may_use(TransportKind::udp, choice)) {
    return fail(Errc::invalid_argument,
                "topic " + in_quotes(topic) + ": the endpoint's choice of transport contradicts the node's");
  }
  return {};
}

Endpoint NodeCore::new_endpoint(Role role, std::string_view topic, const TypeSupport& type,
                                TransportChoice choice) const {
  Endpoint endpoint;
  endpoint.id = random_id();
  endpoint.role = role;
  endpoint.node_id = id_;
  endpoint.life_lease = discovery_->life_signs().lease;
  endpoint.node = options_.name;
  endpoint.topic = without_slash(topic);
  endpoint.type_name = type.name();
  endpoint.type_hash = type.hash();
  endpoint.type_description = announced_description(type.type());
  endpoint.may_use_shm = may_use(TransportKind::shm, choice);
  endpoint.may_use_udp = may_use(TransportKind::udp, choice);
  if (endpoint.may_use_udp) endpoint.addresses = udp_->addresses();
  return endpoint;
}

/// Of the ways that a writer may use, those that are of use for its largest sample: what shared memory cannot
/// take goes by UDP.
Result<void> NodeCore::keep_ways_for(Endpoint& writer) const {
  const auto most = [](bool may_use, const auto& transport) {
    return may_use ? transport->max_sample_bytes() : std::size_t{0};
  };
  const std::size_t by_shm = most(writer.may_use_shm, shm_);
  const std::size_t by_udp = most(writer.may_use_udp, udp_);
  if (writer.max_sample_bytes > std::max(by_shm, by_udp)) {
    return fail(Errc::limit_exceeded, "topic '" + writer.topic + "': PublisherOptions::max_sample_bytes of " +
                                          std::to_string(writer.max_sample_bytes) + " is more than the " +
                                          std::to_string(std::max(by_shm, by_udp)) + " that can be sent");
  }
  writer.may_use_udp = writer.may_use_udp && writer.max_sample_bytes <= by_udp;
  writer.may_use_shm = writer.may_use_shm && (writer.may_use_udp || writer.max_sample_bytes <= by_shm);
  if (!writer.may_use_udp) writer.addresses.clear();
  return {};
}

Result<detail::untyped::Publisher> NodeCore::open_publisher(const std::shared_ptr<NodeCore>& self,
                                                            std::string_view topic, const TypeSupport& type,
                                                            const PublisherOptions& options) {
  if (auto ok = check_endpoint(topic, type, options.transport); !ok) return tl::unexpected(ok.error());
  const Result<Qos> qos = qos_of(options);
  if (!qos) return tl::unexpected(qos.error());
  Endpoint endpoint = new_endpoint(Role::writer, topic, type, options.transport);
  endpoint.qos = *qos;
  endpoint.max_sample_bytes = options.max_sample_bytes;
  endpoint.waits = options.max_blocking.count() > 0;
  if (auto fits = keep_ways_for(endpoint); !fits) return tl::unexpected(fits.error());
  std::shared_ptr<WriterPort> udp;
  if (endpoint.may_use_udp) {
    auto port = udp_->open_writer({.id = endpoint.id,
                                   .type = &type,
                                   .max_blocking = options.max_blocking,
                                   .max_bytes_per_s = options.max_bytes_per_s});
    if (!port) return tl::unexpected(port.error());
    udp = std::move(*port);
  }
  std::function<void()> asserted;
  if (qos->liveliness == Liveliness::manual_by_topic) {
    asserted = [this, id = endpoint.id] { agent_.post([this, id] { reconciler_->program_asserts(id); }); };
  }
  auto core = std::make_shared<PublisherCore>(
      PublisherCore::Spec{endpoint.id, endpoint.topic, &type, options.max_sample_bytes, *qos,
                          options.on_readers_changed, options.on_event, std::move(asserted),
                          options.max_blocking},
      heap_, std::move(udp));
  roster_.enter(*core);
  agent_.post([this, endpoint, core] {
    reconciler_->add_writer(endpoint, core);
    endpoints_changed_.raise();
  });
  // The handle withdraws the endpoint; the agent lets go of the rest.
  std::shared_ptr<PublisherCore> handle(core.get(), [self, core, id = endpoint.id](PublisherCore*) {
    if (is_forked_copy()) return;
    core->close();
    self->roster_.strike_off(*core);
    self->agent_.post([node = self.get(), id] { node->reconciler_->remove(id); });
  });
  return detail::untyped::Publisher(std::move(handle));
}

const TypeSupport& NodeCore::kept(const DynamicType& type) {
  const std::span<const std::byte> bytes = type.description();
  const std::string description(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const std::scoped_lock lock(kept_mutex_);
  return kept_types_.try_emplace(description, type).first->second.support();
}

/// What shared memory keeps of a reader's depth. A reader that asks for more is told so: with a warning if it
/// relies on that.
std::uint32_t NodeCore::shm_depth_of(const Endpoint& reader) {
  const std::uint32_t depth = reader.qos.history_depth;
  const std::uint32_t most = shm_ == nullptr ? depth : shm_->max_depth();
  if (!reader.may_use_shm || depth <= most) return depth;
  const bool reliable = reader.qos.reliability == Reliability::reliable;
  agent_.post(
      [this, level = reliable ? LogLevel::warning : LogLevel::info,
       text = "topic '" + reader.topic + "': SubscriberOptions::depth is " + std::to_string(depth) +
              ", but shared memory keeps " + std::to_string(most) +
              " samples of each publisher on this host: take them sooner, or let reliable publishers "
              "wait for reliable subscribers (PublisherOptions::max_blocking)"] { log_.write(level, text); });
  return most;
}

Result<detail::untyped::Subscriber> NodeCore::open_subscriber(const std::shared_ptr<NodeCore>& self,
                                                              std::string_view topic, const TypeSupport& type,
                                                              detail::untyped::Requirement requirement,
                                                              const SubscriberOptions& options,
                                                              detail::untyped::Callback callback,
                                                              std::shared_ptr<const void> type_owner) {
  if (auto ok = check_endpoint(topic, type, options.transport); !ok) return tl::unexpected(ok.error());
  const Result<Qos> qos = qos_of(options);
  if (!qos) return tl::unexpected(qos.error());
  if (auto ok = Recorder::check(options.recording); !ok) return tl::unexpected(ok.error());
  if (options.max_held < max_held_least || options.max_held > max_held_most) {
    return fail(Errc::invalid_argument,
                "SubscriberOptions::max_held is 2 to 256, not " + std::to_string(options.max_held));
  }
  Result<std::unique_ptr<PollHandle>> poll_handle;
  if (options.pollable) poll_handle = PollHandle::create();
  if (!poll_handle) return tl::unexpected(poll_handle.error());
  const Result<std::uint32_t> slot = slot_for(static_cast<bool>(callback), options.pollable);
  if (!slot) return tl::unexpected(slot.error());
  Endpoint endpoint = new_endpoint(Role::reader, topic, type, options.transport);
  endpoint.qos = *qos;
  endpoint.doorbell = {bells_->id(), *slot};
  // Without a shared page nobody else could ring.
  endpoint.may_use_shm = endpoint.may_use_shm && bells_->id() != 0;
  requirement.mask = type.closed(requirement.mask);
  endpoint.request.reader = endpoint.id;
  endpoint.request.sequence = 1;
  endpoint.request.mask_words = requirement.mask.to_words();
  endpoint.request.min_period_us = *min_period_us_of(options.max_rate_hz);  // checked with the other policies
  Reconciler::NewReader reader;
  if (requirement.recorded) {
    reader.recorder = Recorder::make(type.leaves(), options.recording, [this, id = endpoint.id] {
      agent_.post([this, id] { reconciler_->requirement_changed(id); });
    });
  }
  reader.core = std::make_shared<SubscriberCore>(
      SubscriberCore::Spec{
          .id = endpoint.id,
          .topic = endpoint.topic,
          .type = &type,
          .requirement = requirement,
          .options = options,
          .callback = std::move(callback),
          .type_owner = std::move(type_owner),
          .min_period_us = endpoint.request.min_period_us,
          .rate_changed = [this,
                           id = endpoint.id] { agent_.post([this, id] { reconciler_->rate_changed(id); }); },
          .as_remote = options.recording.as_remote ? heap_ : nullptr,
          .poll_handle = std::move(*poll_handle),
          .shm_depth = shm_depth_of(endpoint)},
      bells_->at(*slot), reader.recorder);
  if (endpoint.may_use_udp) {
    ReaderSpec spec{endpoint.id, &type, options.depth, reader.core.get(), endpoint.doorbell};
    spec.only_waited_for = !reader.core->has_callback() && !options.pollable;
    spec.spin = std::clamp(options.spin, 0ns, std::chrono::nanoseconds(max_spin));
    auto port = udp_->open_reader(spec);
    if (!port) {
      give_slot_back(*slot);
      return tl::unexpected(port.error());
    }
    reader.udp = std::move(*port);
    reader.udp->accept({{.wanted = {requirement.mask, endpoint.request.min_period_us}}});
    reader.core->ports().set(TransportKind::udp, reader.udp);
  }
  const std::shared_ptr<SubscriberCore> core = reader.core;
  if (options.pollable) poller_.add(core);
  const std::shared_ptr<Recorder> recorder = reader.recorder;
  roster_.enter(*core);
  agent_.post([this, endpoint, reader = std::move(reader)]() mutable {
    reconciler_->add_reader(endpoint, std::move(reader));
    endpoints_changed_.raise();
  });
  const auto close = [self, core, recorder, id = endpoint.id, slot = *slot](SubscriberCore*) {
    if (is_forked_copy()) return;
    core->close();
    self->roster_.strike_off(*core);
    if (recorder != nullptr) recorder->detach();
    self->poller_.remove(*core);
    self->agent_.post([node = self.get(), id, slot] {
      node->reconciler_->remove(id);
      node->give_slot_back(slot);
    });
  };
  std::shared_ptr<SubscriberCore> handle(core.get(), close);
  return detail::untyped::Subscriber(std::move(handle));
}

void NodeCore::endpoint_seen(Endpoint endpoint) {
  agent_.post([this, endpoint = std::move(endpoint)] {
    reconciler_->endpoint_seen(endpoint);
    endpoints_changed_.raise();
  });
}

void NodeCore::endpoint_departed(EndpointId id) {
  agent_.post([this, id] {
    reconciler_->endpoint_departed(id);
    endpoints_changed_.raise();
  });
}

void NodeCore::endpoint_lost(EndpointId id) {
  agent_.post([this, id] { reconciler_->endpoint_lost(id); });
}

void NodeCore::request_received(Request request) {
  agent_.post([this, request = std::move(request)] { reconciler_->request_received(request); });
}

void NodeCore::liveliness_asserted(Assertion assertion) {
  agent_.post([this, assertion = std::move(assertion)] { reconciler_->liveliness_asserted(assertion); });
}

void NodeCore::node_lost(NodeId id) {
  agent_.post([this, id] { reconciler_->node_lost(id); });
}

void NodeCore::links_changed(const std::string& summary) {
  log_.write(LogLevel::info, "discovery: " + summary);
}

void NodeCore::link_was_deaf(const std::string& what) {
  links_renewed_.fetch_add(1, std::memory_order_relaxed);
  log_.write(LogLevel::warning, "discovery: " + what);
}

void NodeCore::other_release_found(const std::string& what) {
  log_.write(LogLevel::warning, "discovery: " + what);
}

void NodeCore::control_malformed(std::string why) {
  const std::uint64_t refused = control_malformed_.fetch_add(1, std::memory_order_relaxed) + 1;
  // Whoever floods us must not fill the agent's queue: one complaint in a while is enough.
  const auto now = std::chrono::steady_clock::now();
  if (!log_.wants(LogLevel::warning) || now < next_complaint_.load(std::memory_order_relaxed)) return;
  next_complaint_.store(now + complaint_pause, std::memory_order_relaxed);
  agent_.post([this, refused, why = std::move(why)] {
    log_.write(LogLevel::warning, "control traffic refused, " + std::to_string(refused) + " in all: " + why);
  });
}

template <class Question>
auto NodeCore::ask_agent(Question question) -> decltype(question()) {
  if (agent_.is_current_thread()) return question();
  std::promise<decltype(question())> answer;
  agent_.post([&] { answer.set_value(question()); });
  return answer.get_future().get();
}

Result<DynamicType> NodeCore::find_type(std::string_view topic, std::chrono::nanoseconds timeout) {
  topic = without_slash(topic);
  const auto deadline = deadline_after(timeout);
  for (;;) {
    const std::uint64_t seen = endpoints_changed_.value();
    Result<DynamicType> type = ask_agent([&] { return type_of(topic, reconciler_->endpoints()); });
    // The agent cannot wait for what it would itself bring about.
    const bool may_come = !type && type.error().code == Errc::unavailable && !agent_.is_current_thread();
    if (!may_come || !endpoints_changed_.wait_beyond(seen, deadline)) return type;
  }
}

std::vector<TopicInfo> NodeCore::topics() {
  return topics_of(ask_agent([&] {
    std::vector<Endpoint> copies;
    for (const Endpoint* endpoint : reconciler_->endpoints()) copies.push_back(*endpoint);
    return copies;
  }));
}

DomainSnapshot NodeCore::domain() {
  struct Known {
    std::vector<KnownEndpoint> endpoints;
    PairAccounts accounts;
  };
  Known known = ask_agent([&] {
    return Known{reconciler_->known_endpoints(), reconciler_->known_accounts()};
  });
  return domain_snapshot(std::move(known.endpoints), known.accounts, id_, network_);
}

Result<AccountInquiry> NodeCore::ask_accounts(const std::shared_ptr<NodeCore>& self, std::string_view topic) {
  if (const Result<void> sound = check_topic(topic); !sound) return tl::unexpected(sound.error());
  const std::string name(without_slash(topic));
  agent_.post([this, name] { reconciler_->ask_accounts(name); });
  const auto end = [self, name](const void*) {
    if (is_forked_copy()) return;
    self->agent_.post([node = self.get(), name] { node->reconciler_->ask_accounts_no_more(name); });
  };
  return AccountInquiry(std::shared_ptr<const void>(self.get(), end));
}

NodeStatus NodeCore::status() const {
  NodeStatus status;
  Discovery::Configuration discovery = discovery_->configuration();
  status.discovery = std::move(discovery.summary);
  for (const std::string& warning : discovery.warnings) status.discovery += "; " + warning;
  status.discovery_warnings = std::move(discovery.warnings);
  std::ranges::move(discovery.remarks, std::back_inserter(status.discovery_warnings));
  status.waits_for_network = discovery.waits_for_network;
  status.discovery_interfaces = std::move(discovery.interfaces);
  status.udp = udp_ == nullptr ? "the node rules it out" : udp_->description();
  status.io_uring_in_use = udp_ != nullptr && udp_->uses_io_uring();
  status.lacks_daemon = shm_ != nullptr && shm_->lacks_daemon();
  status.shm = reconciler_->shm_state();
  status.shm_ready = reconciler_->shm_ready();
  if (udp_ != nullptr) {
    const Transport::Counters counters = udp_->counters();
    status.datagrams_malformed = counters.malformed;
    status.datagrams_unknown = counters.unknown + counters.disbelieved;
    status.samples_incomplete = counters.incomplete;
    status.over_limit = counters.over_limit;
  }
  if (shm_ != nullptr) {
    const Transport::Counters counters = shm_->counters();
    status.shm_samples_malformed = counters.malformed;
    status.shm_over_limit = counters.over_limit;
  }
  status.control_malformed = control_malformed_.load(std::memory_order_relaxed);
  status.links_renewed = links_renewed_.load(std::memory_order_relaxed);
  status.control_ignored = reconciler_->control_ignored();
  return status;
}

NodeSnapshot NodeCore::snapshot() const {
  NodeSnapshot snapshot{
      .name = options_.name,
      .domain = options_.domain.value_or(0),
      .version = SFT_VERSION,
      .control_protocol = control_protocol_version(),
      .time = std::chrono::sys_time<std::chrono::nanoseconds>(std::chrono::nanoseconds(realtime_ns())),
      .status = status(),
      .publishers = {},
      .subscribers = {}};
  roster_.describe(snapshot);
  return snapshot;
}

}  // namespace sft::core
