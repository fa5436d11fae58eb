#include "core/node/endpoint_opening.h"

#include <algorithm>
#include <utility>

#include "core/control/described_type.h"
#include "core/names/names.h"
#include "core/names/qos.h"
#include "core/negotiation/requested_selection.h"
#include "core/node/topics.h"
#include "core/platform/random_id.h"

namespace sft::core {

namespace {
// The limit on spinning of the thread that runs callbacks, which has other work, too.
constexpr std::chrono::seconds max_spin{1};
}  // namespace

/// Returns a function for any thread, which posts the event of the endpoint to the agent.
std::function<void()> EndpointOpening::posted(EndpointId id, void (Reconciler::*event)(EndpointId)) const {
  return [&agent = node_.agent, &reconciler = node_.reconciler, id, event] {
    agent.post([&reconciler, id, event] { (reconciler.*event)(id); });
  };
}

/// Writes a line to the log, on the agent's thread.
void EndpointOpening::log(LogLevel level, std::string text) const {
  node_.agent.post([&log = node_.log, level, text = std::move(text)] { log.write(level, text); });
}

bool EndpointOpening::may_use(TransportKind kind, TransportChoice choice) const {
  const TransportChoice other = kind == TransportKind::shm ? TransportChoice::udp : TransportChoice::shm;
  const bool exists = kind == TransportKind::shm ? node_.memory != nullptr : node_.network != nullptr;
  return exists && choice != other && node_.options.transport != other;
}

/// Logs the new name of a renamed topic, because later lines of the log use that name.
void EndpointOpening::log_renaming(const TopicName& name) const {
  if (name.given.empty()) return;
  const std::string by = name.rules.empty() ? "" : ", by the remapping rule " + in_quotes(name.rules.front());
  log(LogLevel::info, "the program's topic " + in_quotes(name.given) + " is " + in_quotes(name.topic) + by);
}

void EndpointOpening::warn_of(const std::string& topic, const std::vector<std::string>& sentences) const {
  for (const std::string& sentence : sentences)
    log(LogLevel::warning, "topic " + in_quotes(topic) + ": " + sentence);
}

Result<void> EndpointOpening::check(std::string_view topic, const TypeSupport& type,
                                    TransportChoice choice) const {
  if (const auto fault = fault_of_name(type.name()); !fault.empty())
    return fail(Errc::invalid_argument, "type name " + in_quotes(type.name()) + " " + std::string(fault));
  if (type.leaves() > leaves_max) {
    return fail(Errc::limit_exceeded,
                std::string(type.name()) + " has more than " + std::to_string(leaves_max) + " fields");
  }
  if (!may_use(TransportKind::shm, choice) && !may_use(TransportKind::udp, choice)) {
    return fail(Errc::invalid_argument,
                "topic " + in_quotes(topic) + ": the endpoint's choice of transport contradicts the node's");
  }
  return {};
}

Result<void> EndpointOpening::check(const SubscriberOptions& options) {
  if (Result<void> sound = Recorder::check(options.recording); !sound) return sound;
  constexpr std::uint32_t least = SubscriberOptions::max_held_least, most = SubscriberOptions::max_held_most;
  if (options.max_held < least || options.max_held > most) {
    return fail(Errc::invalid_argument, "SubscriberOptions::max_held is " + std::to_string(least) + " to " +
                                            std::to_string(most) + ", not " +
                                            std::to_string(options.max_held));
  }
  return {};
}

Endpoint EndpointOpening::describe(Role role, const TopicName& name, const TypeSupport& type,
                                   TransportChoice choice) const {
  Endpoint endpoint;
  endpoint.id = random_id();
  endpoint.role = role;
  endpoint.node_id = node_.id;
  endpoint.node = node_.options.name;
  endpoint.topic = name.topic;
  endpoint.given_topic = name.given;
  endpoint.type_name = type.name();
  endpoint.type_hash = type.hash();
  if (auto description = announced_description(type.type())) {
    endpoint.type_description = *std::move(description);
  } else if (role == Role::writer) {
    log(LogLevel::warning, "topic " + in_quotes(name.topic) +
                               ": the fields of its type are not announced: " + description.error().message);
  }
  endpoint.may_use_memory = may_use(TransportKind::shm, choice);
  endpoint.may_use_network = may_use(TransportKind::udp, choice);
  if (endpoint.may_use_network) endpoint.addresses = node_.network->addresses();
  return endpoint;
}

/// Excludes the transports that cannot carry the largest sample of a writer. Shared memory is not excluded
/// if UDP can carry that sample, because samples that are too large for shared memory are then sent by UDP.
Result<void> EndpointOpening::keep_ways_for_largest_sample(Endpoint& writer) const {
  const auto most = [](bool may_use, const Transport* transport) {
    return may_use ? transport->max_sample_bytes() : std::size_t{0};
  };
  const std::size_t in_memory = most(writer.may_use_memory, node_.memory);
  const std::size_t over_network = most(writer.may_use_network, node_.network);
  if (writer.max_sample_bytes > std::max(in_memory, over_network)) {
    return fail(Errc::limit_exceeded, "topic '" + writer.topic + "': PublisherOptions::max_sample_bytes of " +
                                          std::to_string(writer.max_sample_bytes) + " is more than the " +
                                          std::to_string(std::max(in_memory, over_network)) +
                                          " that can be sent");
  }
  writer.may_use_network = writer.may_use_network && writer.max_sample_bytes <= over_network;
  writer.may_use_memory =
      writer.may_use_memory && (writer.may_use_network || writer.max_sample_bytes <= in_memory);
  if (!writer.may_use_network) writer.addresses.clear();
  return {};
}

Result<EndpointOpening::Writer> EndpointOpening::open_writer(std::string_view topic, const TypeSupport& type,
                                                             const PublisherOptions& options) const {
  const Result<TopicName> name = names().topic(topic, type.name());
  if (!name) return tl::unexpected(name.error());
  log_renaming(*name);
  return open_writer(*name, type, options).map_error([&](const Error& error) {
    return name->explained(error);
  });
}

Result<EndpointOpening::Writer> EndpointOpening::open_writer(const TopicName& name, const TypeSupport& type,
                                                             const PublisherOptions& options) const {
  if (auto ok = check(name.topic, type, options.transport); !ok) return tl::unexpected(ok.error());
  const Result<Qos> qos = qos_of(options);
  if (!qos) return tl::unexpected(qos.error());
  Endpoint endpoint = describe(Role::writer, name, type, options.transport);
  endpoint.qos = *qos;
  endpoint.max_sample_bytes = options.max_sample_bytes;
  endpoint.waits = options.max_blocking.count() > 0;
  if (auto fits = keep_ways_for_largest_sample(endpoint); !fits) return tl::unexpected(fits.error());
  if (options.on_event || options.on_readers_changed) {
    if (auto started = node_.callbacks.start(); !started) return tl::unexpected(started.error());
  }
  const auto book = std::make_shared<DeliveryBook>();
  auto network = open_network(endpoint, type, options, book);
  if (!network) return tl::unexpected(network.error());
  std::function<void()> asserted;
  if (qos->liveliness == Liveliness::manual_by_topic)
    asserted = posted(endpoint.id, &Reconciler::program_asserts);
  auto core = std::make_shared<PublisherCore>(
      PublisherCore::Spec{.id = endpoint.id,
                          .topic = endpoint.topic,
                          .type = &type,
                          .max_sample_bytes = options.max_sample_bytes,
                          .qos = *qos,
                          .on_readers_changed = options.on_readers_changed,
                          .on_event = options.on_event,
                          .callbacks = &node_.callbacks,
                          .asserted = std::move(asserted),
                          .refused =
                              [&agent = node_.agent, &log = node_.log](const std::string& why) {
                                agent.post([&log, why] {
                                  log.write(LogLevel::warning, "a message is not sent: " + why);
                                });
                              },
                          .max_blocking = options.max_blocking,
                          .book = book},
      node_.heap, std::move(*network));
  warn_of(name.topic, options_without_effect(options, endpoint.may_use_network));
  return Writer{std::move(endpoint), std::move(core)};
}

/// Opens the UDP port of a writer. Returns null if the writer must not use UDP.
Result<std::shared_ptr<NetworkWriter>> EndpointOpening::open_network(
    const Endpoint& writer, const TypeSupport& type, const PublisherOptions& options,
    std::shared_ptr<DeliveryBook> book) const {
  if (!writer.may_use_network) return nullptr;
  auto port = node_.network->open_writer({.id = writer.id,
                                          .type = &type,
                                          .max_blocking = options.max_blocking,
                                          .max_bytes_per_s = options.max_bytes_per_s,
                                          .resend_bytes = options.resend_bytes,
                                          .priority = options.priority,
                                          .asynchronous = options.asynchronous,
                                          .book = std::move(book)});
  if (!port) return tl::unexpected(port.error());
  return std::shared_ptr<NetworkWriter>(std::move(*port));
}

Result<EndpointOpening::Reader> EndpointOpening::open_reader(ReaderOrder order) const {
  Result<TopicName> name = names().topic(order.topic, order.type.name());
  if (!name) return tl::unexpected(name.error());
  log_renaming(*name);
  order.topic = name->topic;
  order.name = *name;
  return open_named(std::move(order)).map_error([&](const Error& error) { return name->explained(error); });
}

Result<EndpointOpening::Reader> EndpointOpening::open_named(ReaderOrder order) const {
  if (auto ok = check(order.topic, order.type, order.options.transport); !ok)
    return tl::unexpected(ok.error());
  const Result<Qos> qos = qos_of(order.options);
  if (!qos) return tl::unexpected(qos.error());
  if (auto ok = check(order.options); !ok) return tl::unexpected(ok.error());
  if (order.options.on_event) {
    if (auto started = node_.callbacks.start(); !started) return tl::unexpected(started.error());
  }
  Result<std::unique_ptr<PollHandle>> poll_handle;
  if (order.options.pollable) poll_handle = PollHandle::create();
  if (!poll_handle) return tl::unexpected(poll_handle.error());
  const Result<std::vector<Selection>> selections = all_selections(order);
  if (!selections) return tl::unexpected(selections.error());
  const Result<std::uint32_t> slot = take_slot(order);
  if (!slot) return tl::unexpected(slot.error());
  std::vector<Endpoint> endpoints;
  for (const Selection& selection : *selections) {
    Qos of_selection = *qos;
    if (!endpoints.empty()) of_selection.deadline = {};  // only the first selection has a deadline
    endpoints.push_back(describe_reader(order, selection, of_selection, *slot));
  }
  Reader reader{.core = make_core(endpoints, *slot, *selections, order, std::move(*poll_handle)),
                .endpoints = {},
                .slot = *slot};
  for (std::size_t i = 0; i < endpoints.size(); ++i) {
    auto network = open_network(endpoints[i], *reader.core, i);
    if (!network) {
      give_up(std::move(reader));
      return tl::unexpected(network.error());
    }
    reader.core->ports(i).set_network(*network);
    reader.endpoints.push_back({std::move(endpoints[i]), {reader.core, *std::move(network), i}});
  }
  warn_of(order.name.topic,
          options_without_effect(order.options, may_use(TransportKind::shm, order.options.transport),
                                 order.requirement.recorded));
  return reader;
}

/// Closes the ports of a reader, and then releases its doorbell slot. In this order no transport can ring
/// the doorbell after the slot is free.
void EndpointOpening::give_up(Reader reader) const {
  for (std::size_t i = 0; i < reader.core->selections(); ++i) reader.core->ports(i).set_network(nullptr);
  reader.endpoints.clear();
  node_.slots.give_back(reader.slot);
}

/// Returns the first selection and the further selections, all of them checked and closed, and each with
/// its rate.
Result<std::vector<Selection>> EndpointOpening::all_selections(const ReaderOrder& order) {
  if (order.requirement.recorded && !order.options.further_selections.empty()) {
    return fail(
        Errc::invalid_argument,
        "topic " + in_quotes(order.topic) +
            ": SubscriberOptions::further_selections is not empty, but the fields are recorded: declare "
            "them, or open another subscriber");
  }
  const std::vector<Selection>& further = order.requirement.further;
  if (further.size() >= SubscriberOptions::selections_max) {
    return fail(Errc::limit_exceeded, "topic " + in_quotes(order.topic) + ": a subscriber has at most " +
                                          std::to_string(SubscriberOptions::selections_max) +
                                          " selections, not " + std::to_string(further.size() + 1));
  }
  std::vector<Selection> all{order.requirement.selection};
  all.insert(all.end(), further.begin(), further.end());
  for (Selection& selection : all) {
    const Result<Selection> closed = checked_selection(order.type, selection);
    if (!closed) return tl::unexpected(closed.error());
    if (auto rate = min_period_us_of(rate_hz_of(*closed)); !rate) return tl::unexpected(rate.error());
    selection = *closed;
  }
  return all;
}

Result<std::uint32_t> EndpointOpening::take_slot(const ReaderOrder& order) const {
  const bool has_callback = static_cast<bool>(order.callback);
  if (!has_callback && !order.options.pollable) return node_.slots.take();
  if (has_callback && order.options.pollable) {
    return fail(Errc::invalid_argument,
                "a subscriber has a callback or a file descriptor: leave SubscriberOptions::pollable false");
  }
  const Result<void> started = (has_callback ? node_.dispatcher : node_.poller).start();
  if (!started) return tl::unexpected(started.error());
  return has_callback ? WakeSlots::dispatcher : WakeSlots::poller;
}

Endpoint EndpointOpening::describe_reader(const ReaderOrder& order, const Selection& selection,
                                          const Qos& qos, std::uint32_t slot) const {
  Endpoint endpoint = describe(Role::reader, order.name, order.type, order.options.transport);
  endpoint.qos = qos;
  endpoint.doorbell = {node_.slots.page_id(), slot};
  // Without a shared page, no other process could ring the doorbell.
  endpoint.may_use_memory = endpoint.may_use_memory && node_.slots.page_id() != 0;
  endpoint.request.reader = endpoint.id;
  endpoint.request.sequence = 1;
  const Selection without_rate = selection.without_rate();
  endpoint.request.mask_words = without_rate.mask().to_words();
  if (!without_rate.is_mask()) endpoint.request.parts = without_rate.to_bytes();
  // Both rates have been checked; the lower rate is in force.
  endpoint.request.min_period_us =
      std::max(*min_period_us_of(order.options.max_rate_hz), *min_period_us_of(rate_hz_of(selection)));
  return endpoint;
}

std::shared_ptr<SubscriberCore> EndpointOpening::make_core(const std::vector<Endpoint>& endpoints,
                                                           std::uint32_t slot,
                                                           const std::vector<Selection>& selections,
                                                           ReaderOrder& order,
                                                           std::unique_ptr<PollHandle> poll_handle) const {
  std::vector<Feed::Spec> feeds;
  for (std::size_t i = 0; i < endpoints.size(); ++i) {
    const Endpoint& endpoint = endpoints[i];
    feeds.push_back({.id = endpoint.id,
                     .selection = selections[i].without_rate(),
                     .min_period_us = endpoint.request.min_period_us,
                     .qos = endpoint.qos,
                     .changed = posted(endpoint.id, &Reconciler::requirement_changed)});
  }
  std::shared_ptr<Recorder> recorder;
  if (order.requirement.recorded) {
    recorder = Recorder::make(order.type.leaves(), order.options.recording, feeds.front().changed,
                              ChannelNumbers::clouds_of(order.type.type()));
  }
  return std::make_shared<SubscriberCore>(
      SubscriberCore::Spec{.topic = endpoints.front().topic,
                           .type = &order.type,
                           .feeds = std::move(feeds),
                           .options = order.options,
                           .limits_samples = order.requirement.limits_samples,
                           .callback = std::move(order.callback),
                           .event_callbacks = &node_.callbacks,
                           .type_owner = std::move(order.type_owner),
                           .copies = node_.heap,
                           .poll_handle = std::move(poll_handle),
                           .memory_depth = memory_depth_of(endpoints.front()),
                           .interrupted = &node_.slots.interrupted()},
      node_.slots.at(slot), std::move(recorder));
}

/// Opens the UDP port of a reader. Returns null if the reader must not use UDP.
Result<std::shared_ptr<NetworkReader>> EndpointOpening::open_network(const Endpoint& reader,
                                                                     SubscriberCore& core,
                                                                     std::size_t selection) const {
  if (!reader.may_use_network) return nullptr;
  const SubscriberOptions& options = core.spec().options;
  ReaderSpec spec{reader.id, &core.type(), options.depth, &core, reader.doorbell};
  spec.depth_bytes = options.depth_bytes;
  spec.only_waited_for = !core.has_callback() && !options.pollable;
  spec.spin = std::clamp(options.spin, std::chrono::nanoseconds(0), std::chrono::nanoseconds(max_spin));
  auto port = node_.network->open_reader(spec);
  if (!port) return tl::unexpected(port.error());
  std::shared_ptr<NetworkReader> network = std::move(*port);
  network->accept({{.wanted = {core.feed(selection).spec().selection, reader.request.min_period_us}}});
  return network;
}

/// Returns the number of samples of a writer that shared memory keeps for the reader. If this is less than
/// the reader's depth, a line is logged, which is a warning if the reader is reliable.
std::uint32_t EndpointOpening::memory_depth_of(const Endpoint& reader) const {
  const std::uint32_t depth = reader.qos.history_depth;
  const std::uint32_t most = node_.memory == nullptr ? depth : node_.memory->max_depth();
  if (!reader.may_use_memory || depth <= most) return depth;
  const bool reliable = reader.qos.reliability == Reliability::reliable;
  log(reliable ? LogLevel::warning : LogLevel::info,
      "topic '" + reader.topic + "': SubscriberOptions::depth is " + std::to_string(depth) +
          ", but shared memory keeps " + std::to_string(most) +
          " samples of each publisher on this host: take them sooner, or let reliable publishers "
          "wait for reliable subscribers (PublisherOptions::max_blocking)");
  return most;
}

}  // namespace sft::core
