#include "tests/simulation/negotiation/negotiation_world.h"

#include <algorithm>
#include <array>

#include "tests/simulation/negotiation/negotiation_laws.h"
#include "tests/unit/core/control/endpoint_ids.h"

namespace sft::test {

using core::Endpoint;
using core::HostToken;
using core::Request;
using core::Role;
using core::Route;

namespace {

/// Returns the selection of a number. Even numbers give parts of fields, conditions or both; odd numbers give
/// whole fields.
Selection wish_of(const TypeSupport& type, std::uint64_t number) {
  constexpr std::array<const char*, 6> parts{"data{x,y} @ height > 1",
                                             "data[::4]",
                                             "data{x,y}",
                                             "* @ every 2nd",
                                             "data{x,z}[:100], header.stamp",
                                             "header, data[:9] @ changed(width)"};
  if (number % 2 == 0) return type.parse_selection(parts[number / 2 % parts.size()]).value();
  return FieldMask::from_words(type.leaves(), {{number}});
}

}  // namespace

/// One kind of step: its name in histories, and the function that makes the step.
struct NegotiationWorld::StepKind {
  const char* name;
  void (*happens)(NegotiationWorld& world, std::size_t n, std::size_t other);
};

/// The kinds of steps, in the order of NegotiationStep::What.
const std::array<NegotiationWorld::StepKind, 18> NegotiationWorld::step_kinds{{
    {"word comes",
     [](auto& world, auto n, auto other) { world.deliver(n, world.state_.channels.take(other, n)); }},
    {"word repeated",
     [](auto& world, auto n, auto other) {
       --world.state_.left.repetitions;
       world.deliver(n, world.state_.channels.between(other, n).last);
     }},
    {"reconciles", [](auto& world, auto n, auto) { world.reconcile(n); }},
    {"looks after it", [](auto& world, auto n, auto) { world.look_after_connections(n); }},
    {"daemon connects", [](auto& world, auto, auto) { world.connect_by_daemon(); }},
    {"selection changes", [](auto& world, auto n, auto which) { world.change_selection(n, which); }},
    {"rate changes", [](auto& world, auto n, auto which) { world.change_rate(n, which); }},
    {"lost",
     [](auto& world, auto n, auto other) {
       if (world.state_.nodes[other].up) --world.state_.left.losses;
       world.lose(other, n);
     }},
    {"found", [](auto& world, auto n, auto other) { world.state_.find(other, n); }},
    {"lost one forgotten", [](auto& world, auto n, auto) { world.forget(n); }},
    {"memory changes",
     [](auto& world, auto n, auto host) {
       --world.state_.left.memory_changes;
       world.change_memory(n, host_token(static_cast<std::uint8_t>(host)));
     }},
    {"killed", [](auto& world, auto n, auto) { world.kill(n); }},
    {"started", [](auto& world, auto place, auto) { world.start_node(place); }},
    {"endpoint departs", [](auto& world, auto n, auto which) { world.depart(n, which); }},
    {"sample published",
     [](auto& world, auto n, auto which) {
       --world.state_.left.samples;
       world.state_.publish(n, which);
     }},
    {"datagram comes",
     [](auto& world, auto, auto which) {
       const Datagram datagram = world.state_.take_datagram(which);
       NegotiationLaws(world.state_.asked, world.violation_).check_arrival(world.state_.nodes, datagram);
     }},
    {"datagram lost", [](auto& world, auto, auto which) { world.state_.take_datagram(which); }},
    {"history leaves", [](auto& world, auto n, auto which) { world.give_history(n, which); }},
}};

NegotiationWorld::NegotiationWorld(const Plan& plan, const TypeSupport& type, Random* random)
    : plan_(plan),
      type_(&type),
      random_(random),
      state_{.places = plan.places,
             .left = plan.budget,
             .channels = ControlChannels(random),
             .asked = AskedRequests(type)} {
  state_.nodes.reserve(plan.places + static_cast<std::size_t>(plan.budget.restarts));
  for (std::size_t place = 0; place < plan.places; ++place) start_node(place);
}

const std::vector<NegotiationWorld::Step>& NegotiationWorld::steps() {
  list_steps(state_, steps_);
  return steps_;
}

void NegotiationWorld::take(const Step& step) {
  taken_.push_back(step);
  step_kinds[static_cast<std::size_t>(step.what)].happens(*this, step.node, step.other);
}

void NegotiationWorld::fail(const std::string& what) {
  if (violation_.empty()) violation_ = what;
}

std::string NegotiationWorld::history() const {
  std::string text;
  for (const Step& step : taken_) {
    text += std::string(step_kinds[static_cast<std::size_t>(step.what)].name) + " " +
            std::to_string(step.node) + " " + std::to_string(step.other) + "\n";
  }
  return text;
}

// Steps of nodes and endpoints.

void NegotiationWorld::start_node(std::size_t place) {
  const std::size_t n = state_.nodes.size();
  WorldNode& node = state_.nodes.emplace_back();
  node.id = state_.nodes.size();
  node.place = place;
  node.self = {
      .host = plan_.common_memory ? host_token(1) : HostToken{}, .network = place + 1, .memory_state = ""};
  node.negotiation.self_changed(node.self);
  for (std::size_t other = 0; other < n; ++other) {
    if (!state_.nodes[other].up) continue;
    state_.channels.open(n, other, true);
    state_.channels.open(other, n, false);
    state_.find(other, n);
  }
  for (const EndpointPlan& endpoint : plan_.endpoints) {
    if (endpoint.place == place) add_endpoint(node, endpoint);
  }
}

void NegotiationWorld::add_endpoint(WorldNode& node, const EndpointPlan& plan) {
  Endpoint endpoint;
  endpoint.id = next_id_++;
  endpoint.node_id = node.id;
  node.opened.push_back(endpoint.id);
  endpoint.role = plan.role;
  endpoint.topic = "points";
  endpoint.type_name = type_->name();
  endpoint.type_hash = type_->hash();
  endpoint.may_use_memory = plan.may_use_memory;
  endpoint.may_use_network = plan.may_use_network;
  endpoint.qos = plan.qos;
  if (plan.may_use_network) endpoint.addresses = {{static_cast<std::uint32_t>(node.place), 7000, 1 << 20}};
  if (plan.role == Role::reader) {
    const FieldMask mask = type_->closed(FieldMask::from_words(type_->leaves(), {{std::uint64_t{1}}}));
    endpoint.request = {.reader = endpoint.id,
                        .sequence = 1,
                        .mask_words = mask.to_words(),
                        .listening = {},
                        .attached = {},
                        .begun = {}};
    node.readers[endpoint.id].endpoint = endpoint;
    node.readers[endpoint.id].wanted = mask;
  } else {
    node.writers[endpoint.id].endpoint = endpoint;
  }
  node.negotiation.local_added(endpoint, *type_);
  const auto n = static_cast<std::size_t>(&node - state_.nodes.data());
  if (plan.role == Role::reader) note_request(n, endpoint.id);
  changed(n, true);
  announce(n, endpoint.id);
}

void NegotiationWorld::kill(std::size_t n) {
  --state_.left.restarts;
  state_.nodes[n].up = false;
  state_.channels.close_to(n);
  for (WorldNode& node : state_.nodes) {
    for (auto& [id, reader] : node.readers) {
      std::erase_if(reader.fed, [&](Id writer) { return state_.nodes[n].writers.contains(writer); });
    }
  }
}

void NegotiationWorld::depart(std::size_t n, std::size_t which) {
  --state_.left.departures;
  WorldNode& node = state_.nodes[n];
  const bool is_writer = which < node.writers.size();
  const Id id =
      is_writer ? nth(node.writers, which).first : nth(node.readers, which - node.writers.size()).first;
  node.negotiation.local_removed(id);
  node.writers.erase(id);
  node.readers.erase(id);
  node.forget_history(id);
  node.announced.erase(id);
  node.sent.erase(id);
  state_.channels.send(n, {.id = id});
  for (WorldNode& other : state_.nodes) {
    for (auto& [reader_id, reader] : other.readers) std::erase(reader.fed, id);
  }
  changed(n, true);
}

void NegotiationWorld::change_selection(std::size_t n, std::size_t which) {
  const int left = --state_.left.selection_changes;
  auto& [id, reader] = nth(state_.nodes[n].readers, which);
  const auto first_possibility = static_cast<std::uint64_t>(left == 0 ? 3 : 2 * left);
  const std::uint64_t number = random_ != nullptr ? (*random_)() : first_possibility;
  // The selection is not closed, because the serving side closes it.
  const Selection wish = wish_of(*type_, number);
  const std::uint32_t period = state_.asked.last(id).request.min_period_us;
  const bool is_new = state_.nodes[n].negotiation.requirement_changed(id, {wish, period});
  if (!is_new && !(type_->closed(wish) == type_->closed(reader.wanted)))
    return fail("another selection is the same");
  if (!is_new) return;
  reader.wanted = wish;
  note_request(n, id);
  changed(n, is_new);
  send_request(n, id);
}

void NegotiationWorld::change_rate(std::size_t n, std::size_t which) {
  --state_.left.rate_changes;
  const auto& [id, reader] = nth(state_.nodes[n].readers, which);
  const std::uint32_t was = state_.asked.last(id).request.min_period_us;
  const bool rises = was == 0 || (random_ != nullptr && (*random_)() % 2 == 0);
  const bool is_new =
      state_.nodes[n].negotiation.requirement_changed(id, {reader.wanted, rises ? was + 1000 : 0});
  if (!is_new) return fail("another rate is the same");
  note_request(n, id);
  changed(n, is_new);
  send_request(n, id);
}

/// Models Negotiation::self_changed and Reconciler::look_after_memory.
void NegotiationWorld::change_memory(std::size_t n, const HostToken& host) {
  WorldNode& node = state_.nodes[n];
  node.self.host = host;
  const bool dirty = node.negotiation.self_changed(node.self);
  for (auto& [id, writer] : node.writers) {
    writer.port = false;
    for (WorldNode& other : state_.nodes) {
      for (auto& [reader_id, reader] : other.readers) std::erase(reader.fed, id);
    }
  }
  for (auto& [id, reader] : node.readers) {
    reader.subscribed.clear();
    reader.fed.clear();
    for (auto& [writer, heard] : reader.heard) heard.memory = false;
    note_request(n, id);
    if (!node.negotiation.local(id)->request.attached.empty()) fail("attached to memory that is gone");
  }
  changed(n, dirty);
  reconcile(n);
  for (const auto& [id, writer] : node.writers) announce(n, id);
  for (const auto& [id, reader] : node.readers) {
    announce(n, id);
    send_request(n, id);
  }
}

/// Sends all histories that a writer owes at present, each whole, as Reconciler::look_after_histories does.
void NegotiationWorld::give_history(std::size_t n, std::size_t which) {
  WorldNode& node = state_.nodes[n];
  auto& [id, writer] = nth(node.writers, which);
  bool dirty = false;
  for (const Route& route : writer.in_force.memory) {
    if (route.history != 0) history_comes(id, route.reader, TransportKind::shm);
  }
  for (const Route& route : writer.in_force.network) {
    if (route.history == 0) continue;
    history_comes(id, route.reader, TransportKind::udp);
    if (node.has_begun(id, route.reader, state_.asked)) writer.history_given.insert(route.reader);
    dirty |= node.negotiation.history_given(id, route.reader);
  }
  changed(n, dirty);
}

/// Makes a retained sample of the writer arrive at that reader alone, if the reader still exists and listens.
void NegotiationWorld::history_comes(Id writer, Id reader, TransportKind path) {
  const bool over_network = path == TransportKind::udp;
  for (std::size_t n = 0; n < state_.nodes.size(); ++n) {
    const auto here = state_.nodes[n].readers.find(reader);
    if (!state_.nodes[n].up || here == state_.nodes[n].readers.end() ||
        !holds(over_network ? here->second.connected : here->second.fed, writer))
      continue;
    const Request& said = state_.nodes[n].negotiation.local(reader)->request;
    if (!holds(over_network ? said.listening : said.attached, writer)) continue;
    if (!state_.nodes[n].negotiation.history_began(reader, writer)) continue;
    note_request(n, reader);
    changed(n, true);
    send_request(n, reader);
  }
}

}  // namespace sft::test
