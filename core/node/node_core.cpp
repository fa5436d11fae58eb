#include "core/node/node_core.h"

#include <future>
#include <iterator>
#include <utility>

#include "core/names/names.h"
#include "core/names/qos.h"
#include "core/node/simulated_clock.h"
#include "core/node/topics.h"
#include "core/platform/clock.h"
#include "core/platform/network_id.h"
#include "core/platform/random_id.h"
#include "core/platform/thread.h"

namespace sft::core {

using namespace std::chrono_literals;

namespace {
/// Without /proc, a node has a random network id, so that it mistakes no other host for its own.
constexpr const char* without_proc =
    "without /proc this program does not know which others are on its host: it treats them as on another "
    "host, and does not reach them if the loopback is the only interface; mount /proc";

/// A search for a type hears subscribers, too, if no publisher has announced the type within this time. If
/// all nodes that search for types did that at once, all nodes would have to announce all their subscribers
/// to each other.
constexpr std::chrono::seconds publishers_first{1};
/// The period in which a search for a type checks if it was interrupted. A signal handler may interrupt the
/// search, but cannot wake it.
constexpr std::chrono::milliseconds interrupt_look_period{100};

void log_calls_left_out(CallbackThread& callbacks, NodeLog& log) {
  const std::uint64_t left_out = callbacks.take_left_out();
  if (left_out == 0) return;
  log.write(LogLevel::warning, std::to_string(left_out) +
                                   " calls for events, readers and log lines were left out, because a "
                                   "callback of this program took long");
}

void log_unfit(const std::vector<std::string>& rules, NodeLog& log) {
  for (const std::string& rule : rules) {
    log.write(LogLevel::warning,
              "the remapping rule " + in_quotes(rule) + " fits no topic and no node of this program");
  }
}

VanillaAccess::Setup vanilla_setup(const NodeOptions& options, const RosDiscovery& ros,
                                   const std::string& ros_distro, std::function<void()> endpoints_changed) {
  using enum NodeOptions::VanillaDds;
  return {.choice = ros.is_off ? never : options.vanilla_dds.value_or(automatic),
          .plan = {.domain = options.domain.value_or(0),
                   .user_config = options.cyclonedds_config.value_or(""),
                   .ros = ros,
                   .names = options.dds_names.value_or(DdsNames::ros2),
                   .threads = options.threads.discovery,
                   .guid_bytes = guid_bytes_of(ros_distro)},
          .node = options.name,
          .sender = options.threads.sender,
          .endpoints_changed = std::move(endpoints_changed)};
}

/// Logs once that the topic "/clock", which the node follows, has no publisher.
class MissingClock {
 public:
  MissingClock(const NodeOptions& options, const NodeNames& names) {
    if (!options.use_sim_time) return;
    if (const Result<TopicName> name = names.topic(SimulatedClock::topic)) topic_ = name->topic;
    due_ = std::chrono::steady_clock::now() + SimulatedClock::timeout;
  }
  void look(const Reconciler& reconciler, NodeLog& log) {
    if (std::chrono::steady_clock::now() < due_) return;
    due_ = Time::max();
    for (const TableEntry* entry : reconciler.endpoints())
      if (entry->endpoint.role == Role::writer && entry->endpoint.topic == topic_) return;
    log.write(LogLevel::warning, "use_sim_time: there is no publisher of the topic " + in_quotes(topic_) +
                                     ", so the time of the node, Node::now(), is 0 until a publisher comes");
  }

 private:
  std::string topic_;
  Time due_ = Time::max();
};
}  // namespace

Result<std::shared_ptr<NodeCore>> NodeCore::open(const NodeOptions& options, Parts parts) {
  if (const auto fault = fault_of_name(options.name); !fault.empty())
    return fail(Errc::invalid_argument,
                "the node's name " + in_quotes(options.name) + " " + std::string(fault));
  const std::shared_ptr<BufferPool> heap = parts.heap;
  const auto names = std::make_shared<NodeNames>(std::move(parts.names));
  const std::string complaint = parts.log.complaint;
  const RosDiscovery ros = parts.ros;
  const std::string ros_distro = parts.ros_distro;
  std::shared_ptr<NodeCore> node(new NodeCore(options, std::move(parts)), &NodeCore::dispose);
  if (options.log) {
    if (Result<void> started = node->callbacks_.start(); !started) return tl::unexpected(started.error());
  }
  const DiscoveryOptions discovery{.domain = options.domain.value_or(0),
                                   .settings = options.discovery,
                                   .user_config = options.cyclonedds_config.value_or(""),
                                   .threads = options.threads.discovery};
  auto opened = Discovery::open(discovery, node->by_agent(&NodeCore::take_events));
  if (!opened) return tl::unexpected(opened.error());
  node->discovery_ = std::move(*opened);
  if (!complaint.empty()) node->log_.write(LogLevel::warning, complaint);
  if (!network_id()) node->log_.write(LogLevel::warning, without_proc);
  for (const std::string& text : options_without_effect(options)) node->log_.write(LogLevel::warning, text);
  const Discovery::Configuration configuration = node->discovery_->configuration();
  for (const auto* texts : {&configuration.warnings, &configuration.remarks}) {
    for (const std::string& text : *texts) node->log_.write(LogLevel::warning, "discovery: " + text);
  }
  node->reconciler_ = std::make_unique<Reconciler>(
      node->network_id_, node->memory_.get(), node->network_.get(), *node->discovery_, node->dispatcher_,
      node->log_, vanilla_setup(node->options_, ros, ros_distro, node->by_agent(&NodeCore::vanilla_changed)));
  node->opening_.emplace(EndpointOpening::Node{.options = node->options_,
                                               .names = names,
                                               .id = node->id_,
                                               .memory = node->memory_.get(),
                                               .network = node->network_.get(),
                                               .heap = heap,
                                               .slots = node->wake_slots_,
                                               .dispatcher = node->dispatcher_,
                                               .poller = node->poller_,
                                               .callbacks = node->callbacks_,
                                               .agent = node->agent_,
                                               .reconciler = *node->reconciler_,
                                               .log = node->log_});
  Reconciler* const reconciler = node->reconciler_.get();
  const Agent::Duties duties{.tick =
                                 [node = node.get(), reconciler, heap, names,
                                  missing_clock = MissingClock(options, *names)]() mutable {
                                   log_calls_left_out(node->callbacks_, node->log_);
                                   log_unfit(names->take_unfit_rules(std::chrono::steady_clock::now()),
                                             node->log_);
                                   missing_clock.look(*reconciler, node->log_);
                                   heap->give_back(std::chrono::steady_clock::now());
                                   node->take_events();
                                   return reconciler->tick();
                                 },
                             .idle = [reconciler] { return reconciler->reconcile(); }};
  const Result<void> started = node->agent_.start({"agent " + options.name, options.threads.agent}, duties);
  if (!started) return tl::unexpected(started.error());
  return node;
}

NodeCore::NodeCore(const NodeOptions& options, Parts parts)
    : options_(options),
      id_(random_id()),
      network_id_(network_id().value_or(random_id())),
      memory_(std::move(parts.memory)),
      network_(std::move(parts.network)),
      callbacks_({"event " + options.name, options.threads.callbacks}),
      log_(options.name, parts.log.threshold, posted(parts.log.sink)),
      dispatcher_(wake_slots_.at(WakeSlots::dispatcher), {"call " + options.name, options.threads.callbacks}),
      poller_(wake_slots_.at(WakeSlots::poller), {"poll " + options.name, options.threads.callbacks}) {}

NodeCore::~NodeCore() {
  if (opening_) agent_.post([this] { log_unfit(opening_->names().leave(), log_); });
  agent_.stop();  // runs the posted tasks first, so that the endpoints are withdrawn
  discovery_.reset();
  callbacks_.stop();
}

std::function<void()> NodeCore::by_agent(void (NodeCore::*act)()) {
  return [agent = shared_agent_, this, act] { agent->post([this, act] { (this->*act)(); }); };
}

/// Returns a sink that posts lines to the callback thread. The agent does not call the sink itself, because
/// the program's sink may take long, or wait for the agent. Writing to standard error may take long, too,
/// if its reader has stopped. If the program has no sink of its own, the thread starts with the first line.
NodeOptions::LogSink NodeCore::posted(const NodeOptions::LogSink& sink) {
  if (!sink) return {};
  return [this, sink](LogLevel level, std::string_view line) {
    if (callbacks_.start())
      callbacks_.post(this, [sink, level, line = std::string(line)] { sink(level, line); });
  };
}

/// Destroys the node. The last handle may be released within a callback of this node or of another one. The
/// destructor waits for the thread of this node's callbacks, which may wait for the callback that releases
/// the handle. In this case another thread destroys the node.
void NodeCore::dispose(NodeCore* node) {
  // The threads of the node do not exist here, and its sockets and files belong to the parent.
  if (is_forked_copy()) return;
  const bool in_callback = SubscriberCore::in_callback() || CallbackThread::in_call() ||
                           node->agent_.is_current_thread() || node->dispatcher_.is_current_thread() ||
                           node->poller_.is_current_thread();
  if (!in_callback) {
    delete node;
  } else if (auto thread = start_thread("sft-close", [node] { delete node; })) {
    thread->detach();
  } else {
    node->agent_.post([node, why = thread.error().message] {
      node->log_.write(LogLevel::error, "the node stays open: " + why);
    });
  }
}

Result<detail::untyped::Publisher> NodeCore::open_publisher(const std::shared_ptr<NodeCore>& self,
                                                            std::string_view topic, const TypeSupport& type,
                                                            const PublisherOptions& options) {
  if (is_forked_copy()) return fail(Errc::unavailable, refuses_forked_copies);
  if (agent_.is_behind(registry_.size())) ask_agent([] {});
  Result<EndpointOpening::Writer> writer = opening_->open_writer(topic, type, options);
  if (!writer) return tl::unexpected(writer.error());
  const std::shared_ptr<PublisherCore> core = writer->core;
  const EndpointId id = writer->endpoint.id;
  registry_.enter(*core);
  agent_.post([this, writer = std::move(*writer)] {
    reconciler_->add_writer(writer.endpoint, writer.core);
    endpoints_changed_.raise();
  });
  // The release of the last handle closes the publisher. Then the agent withdraws the endpoint and closes
  // its ports.
  const auto close = [self, core, id](PublisherCore*) {
    if (is_forked_copy()) return;
    core->close();
    self->registry_.strike_off(*core);
    self->agent_.post([node = self.get(), id] { node->reconciler_->remove(id); });
  };
  return detail::untyped::Publisher(std::shared_ptr<PublisherCore>(core.get(), close));
}

Result<detail::untyped::Subscriber> NodeCore::open_subscriber(const std::shared_ptr<NodeCore>& self,
                                                              EndpointOpening::ReaderOrder order) {
  if (is_forked_copy()) return fail(Errc::unavailable, refuses_forked_copies);
  // The agent releases the doorbells of subscribers that other threads have closed. If many of its tasks
  // are queued, this thread waits for the agent.
  if (agent_.is_behind()) ask_agent([] {});
  const bool pollable = order.options.pollable;
  Result<EndpointOpening::Reader> reader = opening_->open_reader(std::move(order));
  if (!reader) return tl::unexpected(reader.error());
  const std::shared_ptr<SubscriberCore> core = reader->core;
  std::vector<EndpointId> ids;
  for (const EndpointOpening::ReaderEndpoint& opened : reader->endpoints) ids.push_back(opened.endpoint.id);
  const auto close = [self, core, ids = std::move(ids), slot = reader->slot](SubscriberCore*) {
    if (is_forked_copy()) return;
    core->close();
    self->registry_.strike_off(*core);
    self->poller_.remove(*core);
    self->agent_.post([node = self.get(), ids, slot] {
      for (const EndpointId id : ids) node->reconciler_->remove(id);
      node->wake_slots_.give_back(slot);
    });
  };
  if (pollable) poller_.add(core);
  registry_.enter(*core);
  agent_.post([this, reader = std::move(*reader)]() mutable {
    for (EndpointOpening::ReaderEndpoint& opened : reader.endpoints)
      reconciler_->add_reader(opened.endpoint, std::move(opened.parts));
    endpoints_changed_.raise();
  });
  return detail::untyped::Subscriber(std::shared_ptr<SubscriberCore>(core.get(), close));
}

void NodeCore::take_events() {
  for (const DiscoveryEvent& event : discovery_->take_events()) reconciler_->take(event);
  endpoints_changed_.raise();
}

template <class Question>
auto NodeCore::ask_agent(Question question) -> decltype(question()) {
  if (agent_.is_current_thread()) return question();
  using Answer = decltype(question());
  std::promise<Answer> answer;
  agent_.post([&] {
    if constexpr (std::is_void_v<Answer>) {
      question();
      answer.set_value();
    } else {
      answer.set_value(question());
    }
  });
  return answer.get_future().get();
}

void NodeCore::hear(bool readers_too) {
  discovery_->hear(Role::writer);
  if (readers_too) discovery_->hear(Role::reader);
}

Result<DynamicType> NodeCore::find_type(std::string_view topic, std::chrono::nanoseconds timeout) {
  if (is_forked_copy()) return fail(Errc::unavailable, refuses_forked_copies);
  const Result<TopicName> name = opening_->names().topic(topic);
  if (!name) return tl::unexpected(name.error());
  // The agent's thread must not wait for work that it has to do itself.
  const bool may_wait = !agent_.is_current_thread();
  const Time begun = std::chrono::steady_clock::now();
  const Time deadline = may_wait ? deadline_after(timeout) : begun;
  const Time readers_at = deadline - begun <= publishers_first ? begun : begun + publishers_first;
  const auto explained = [&](Result<DynamicType> type) {
    return std::move(type).map_error([&](const Error& error) { return name->explained(error); });
  };
  for (;;) {
    const Time now = std::chrono::steady_clock::now();
    const bool hears_readers = now >= readers_at;
    const std::uint64_t seen = endpoints_changed_.value();
    ask_agent([&] { hear(hears_readers); });
    // Announcements that discovery had received before were posted to the agent earlier than this question,
    // and so are contained in the answer.
    Result<DynamicType> type = ask_agent(
        [&] { return type_of(name->topic, reconciler_->endpoints(), options_.domain.value_or(0)); });
    const bool may_come = !type && type.error().code == Errc::unavailable && may_wait;
    if (!may_come || now >= deadline) return explained(std::move(type));
    if (is_interrupted()) return fail(Errc::unavailable, "Node::interrupt() has ended the search for a type");
    endpoints_changed_.wait_beyond(
        seen, std::min(hears_readers ? deadline : readers_at, now + interrupt_look_period));
  }
}

void NodeCore::interrupt() noexcept {
  if (is_forked_copy()) return;
  wake_slots_.interrupt();
  if (network_ != nullptr) network_->wake_receiver();
}

std::vector<TopicInfo> NodeCore::topics() {
  if (is_forked_copy()) return {};
  ask_agent([this] { hear(true); });
  return topics_of(ask_agent([this] { return copies_of_endpoints(); }));
}

/// Called by the agent only.
std::vector<TableEntry> NodeCore::copies_of_endpoints() const {
  std::vector<TableEntry> copies;
  for (const TableEntry* entry : reconciler_->endpoints()) copies.push_back(*entry);
  return copies;
}

DomainSnapshot NodeCore::domain() {
  if (is_forked_copy()) return {};
  struct Known {
    std::vector<TableEntry> endpoints;
    PairAccounts accounts;
    VanillaView vanilla;
  };
  ask_agent([this] {
    hear(true);
    reconciler_->observe();
    reconciler_->reports().ask_for_progress(std::chrono::steady_clock::now());
  });
  Known known = ask_agent([&] {
    return Known{copies_of_endpoints(), reconciler_->reports().accounts(), reconciler_->vanilla()};
  });
  DomainSnapshot snapshot = domain_snapshot(std::move(known.endpoints), known.accounts, id_, network_id_);
  add_vanilla(snapshot, known.vanilla, known.accounts);
  return snapshot;
}

Result<AccountInquiry> NodeCore::ask_accounts(const std::shared_ptr<NodeCore>& self, std::string_view topic) {
  if (is_forked_copy()) return fail(Errc::unavailable, refuses_forked_copies);
  const Result<TopicName> found = opening_->names().topic(topic);
  if (!found) return tl::unexpected(found.error());
  const std::string& name = found->topic;
  agent_.post([this, name] {
    hear(true);
    reconciler_->reports().ask(name);
  });
  const auto end = [self, name](const void*) {
    if (is_forked_copy()) return;
    self->agent_.post([node = self.get(), name] { node->reconciler_->reports().ask_no_more(name); });
  };
  return AccountInquiry(std::shared_ptr<const void>(self.get(), end));
}

NodeStatus NodeCore::status() const {
  NodeStatus status;
  status.domain = options_.domain.value_or(0);
  if (is_forked_copy()) {
    status.udp = status.shm = status.discovery = refuses_forked_copies;
    return status;
  }
  Discovery::Configuration discovery = discovery_->configuration();
  status.discovery = std::move(discovery.summary);
  for (const std::string& warning : discovery.warnings) status.discovery += "; " + warning;
  status.discovery_warnings = std::move(discovery.warnings);
  std::ranges::move(discovery.remarks, std::back_inserter(status.discovery_warnings));
  status.waits_for_network = discovery.waits_for_network;
  status.discovery_interfaces = std::move(discovery.interfaces);
  status.udp = network_ == nullptr ? "the node rules it out" : network_->description();
  if (network_ != nullptr) network_->add_to(status);
  if (network_ == nullptr) status.quick_paths = no_quick_paths("the node rules UDP out");
  status.lacks_daemon = memory_ != nullptr && memory_->lacks_daemon();
  status.shm = reconciler_->transports().memory_state();
  status.shm_ready = reconciler_->transports().memory_ready();
  if (network_ != nullptr) {
    const Transport::Counters counters = network_->counters();
    status.datagrams_malformed = counters.malformed;
    status.datagrams_unknown = counters.unknown + counters.rejected;
    status.samples_incomplete = counters.incomplete;
    status.over_limit = counters.over_limit;
  }
  if (memory_ != nullptr) {
    const Transport::Counters counters = memory_->counters();
    status.shm_samples_malformed = counters.malformed;
    status.shm_over_limit = counters.over_limit;
  }
  status.control_malformed = reconciler_->counts().malformed.load(std::memory_order_relaxed);
  status.links_renewed = reconciler_->counts().links_renewed.load(std::memory_order_relaxed);
  status.control_ignored = reconciler_->counts().ignored.load(std::memory_order_relaxed);
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
  if (!is_forked_copy()) registry_.describe(snapshot);
  return snapshot;
}

}  // namespace sft::core
