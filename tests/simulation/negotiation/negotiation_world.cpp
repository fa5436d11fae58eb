#include "tests/simulation/negotiation/negotiation_world.h"

#include <algorithm>
#include <array>
#include <iterator>

#include "tests/unit/core/control/endpoint_ids.h"

namespace sft::test {

using core::Endpoint;
using core::HostToken;
using core::Request;
using core::Role;
using core::Route;

namespace {

constexpr std::array<const char*, 22> names{"announcement comes",
                                            "request comes",
                                            "announcement repeated",
                                            "request repeated",
                                            "reconciles",
                                            "looks after it",
                                            "daemon connects",
                                            "mask changes",
                                            "rate changes",
                                            "lost",
                                            "found",
                                            "lost one forgotten",
                                            "memory changes",
                                            "killed",
                                            "started",
                                            "endpoint departs",
                                            "sample published",
                                            "datagram comes",
                                            "datagram lost",
                                            "history leaves",
                                            "node falls silent",
                                            "node heard again"};

HostToken token(std::uint8_t n) {
  HostToken t;
  t.bytes.fill(n);
  return t;
}

}  // namespace

NegotiationWorld::NegotiationWorld(const Plan& plan, const TypeSupport& type, Random* random)
    : plan_(plan), type_(&type), random_(random), left_(plan.budget) {
  nodes_.reserve(plan.places + static_cast<std::size_t>(plan.budget.restarts));
  for (std::size_t place = 0; place < plan.places; ++place) start_node(place);
}

void NegotiationWorld::fail(const std::string& what) {
  if (violation_.empty()) violation_ = what;
}

std::string NegotiationWorld::history() const {
  std::string text;
  for (const Step& step : taken_) {
    text += std::string(names[static_cast<std::size_t>(step.what)]) + " " + std::to_string(step.node) + " " +
            std::to_string(step.other) + "\n";
  }
  return text;
}

// The events that may happen.

void NegotiationWorld::add(What what, std::size_t node, std::size_t other) {
  steps_.push_back({what, static_cast<std::uint8_t>(node), static_cast<std::uint8_t>(other)});
}

const std::vector<NegotiationWorld::Step>& NegotiationWorld::steps() {
  steps_.clear();
  for (const auto& [ends, unused] : channels_) steps_of_pair(ends.first, ends.second);
  std::uint64_t places_in_use = 0;
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    if (!nodes_[n].up) continue;
    places_in_use |= std::uint64_t{1} << nodes_[n].place;
    steps_of_node(n);
  }
  for (std::size_t place = 0; place < plan_.places; ++place) {
    if ((places_in_use >> place & 1) == 0) add(What::node_started, place);
  }
  if (connect_by_daemon(true)) add(What::daemon_connects, 0);
  for (std::size_t i = 0; i < datagrams_.size(); ++i) {
    add(What::datagram_comes, 0, i);
    add(What::datagram_lost, 0, i);
  }
  return steps_;
}

void NegotiationWorld::steps_of_pair(std::size_t from, std::size_t to) {
  const Channel& c = channel(from, to);
  if (!c.announcements.empty()) add(What::announcement_comes, to, from);
  if (!c.requests.empty()) add(What::request_comes, to, from);
  if (left_.repetitions > 0 && c.last_announcement.id != 0) add(What::announcement_repeated, to, from);
  if (left_.repetitions > 0 && c.last_request != nullptr) add(What::request_repeated, to, from);
  if (c.found && (left_.losses > 0 || !nodes_[from].up)) add(What::node_lost, to, from);
  if (!c.found && nodes_[from].up) add(What::node_found, to, from);
  const bool silent = knows_as_silent(from, to);
  if (silent && nodes_[from].up) add(What::node_heard_again, to, from);
  if (!silent && c.found && left_.silences > 0) add(What::node_falls_silent, to, from);
}

void NegotiationWorld::steps_of_node(std::size_t n) {
  const Node& node = nodes_[n];
  if (node.dirty) add(What::agent_reconciles, n);
  if (connections_changed(node)) add(What::agent_looks_after_connections, n);
  const auto is_lost = [](const auto& told) { return told.second.lost_since.has_value(); };
  if (std::any_of(node.told.begin(), node.told.end(), is_lost)) add(What::lost_forgotten, n);
  for (std::size_t i = 0; i < node.readers.size() && left_.mask_changes > 0; ++i)
    add(What::mask_changes, n, i);
  for (std::size_t i = 0; i < node.readers.size() && left_.rate_changes > 0; ++i)
    add(What::rate_changes, n, i);
  for (std::uint8_t i = 0; i < 3 && left_.memory_changes > 0; ++i) {
    if (node.self.host != token(i)) add(What::memory_changes, n, i);
  }
  if (left_.restarts > 0) add(What::node_killed, n);
  const std::size_t endpoints = node.writers.size() + node.readers.size();
  for (std::size_t i = 0; i < endpoints && left_.departures > 0; ++i) add(What::endpoint_departs, n, i);
  for (std::size_t i = 0; i < node.writers.size() && left_.samples > 0; ++i)
    add(What::sample_published, n, i);
  for (std::size_t i = 0; i < node.writers.size(); ++i) {
    if (owes_history(std::next(node.writers.begin(), static_cast<std::ptrdiff_t>(i))->second))
      add(What::history_leaves, n, i);
  }
}

void NegotiationWorld::take(const Step& step) {
  taken_.push_back(step);
  const std::size_t n = step.node;
  const std::size_t other = step.other;
  switch (step.what) {
    case What::announcement_comes: {
      Channel& c = channel(other, n);
      c.last_announcement = c.announcements.front();
      c.announcements.pop_front();
      return deliver(n, c.last_announcement);
    }
    case What::request_comes: {
      Channel& c = channel(other, n);
      const auto which = coin() ? static_cast<std::ptrdiff_t>((*random_)() % c.requests.size()) : 0;
      c.last_request = c.requests[static_cast<std::size_t>(which)];
      c.requests.erase(c.requests.begin() + which);
      return deliver(n, *c.last_request);
    }
    case What::announcement_repeated:
      --left_.repetitions;
      return deliver(n, channel(other, n).last_announcement);
    case What::request_repeated:
      --left_.repetitions;
      return deliver(n, *channel(other, n).last_request);
    case What::agent_reconciles:
      return reconcile(n);
    case What::agent_looks_after_connections:
      return look_after_connections(n);
    case What::daemon_connects:
      connect_by_daemon(false);
      return;
    case What::mask_changes:
      --left_.mask_changes;
      return change_mask(n, other);
    case What::rate_changes:
      --left_.rate_changes;
      return change_rate(n, other);
    case What::node_lost:
      if (nodes_[other].up) --left_.losses;
      return lose(other, n);
    case What::node_found:
      return find(other, n);
    case What::lost_forgotten:
      return forget(n);
    case What::memory_changes:
      --left_.memory_changes;
      return change_memory(n, token(step.other));
    case What::node_killed:
      --left_.restarts;
      return kill(n);
    case What::node_started:
      return start_node(n);
    case What::endpoint_departs:
      --left_.departures;
      return depart(n, other);
    case What::sample_published:
      --left_.samples;
      return publish(n, other);
    case What::datagram_comes:
      return arrive(other);
    case What::datagram_lost:
      datagrams_.erase(datagrams_.begin() + static_cast<std::ptrdiff_t>(other));
      return;
    case What::history_leaves:
      return give_history(n, other);
    case What::node_falls_silent:
      --left_.silences;
      return fall_silent(other, n);
    case What::node_heard_again:
      return hear_again(other, n);
  }
}

// Nodes and endpoints.

void NegotiationWorld::start_node(std::size_t place) {
  const std::size_t n = nodes_.size();
  Node& node = nodes_.emplace_back();
  node.id = nodes_.size();
  node.place = place;
  node.self = {
      .host = plan_.common_memory ? token(1) : HostToken{}, .network = place + 1, .memory_state = ""};
  node.negotiation.self_changed(node.self);
  for (std::size_t other = 0; other < n; ++other) {
    if (!nodes_[other].up) continue;
    channels_[{n, other}].found = true;
    channels_[{other, n}];
    find(other, n);
  }
  for (const EndpointPlan& endpoint : plan_.endpoints) {
    if (endpoint.place == place) add_endpoint(node, endpoint);
  }
}

void NegotiationWorld::add_endpoint(Node& node, const EndpointPlan& plan) {
  Endpoint endpoint;
  endpoint.id = next_id_++;
  endpoint.node_id = node.id;
  node.opened.push_back(endpoint.id);
  endpoint.role = plan.role;
  endpoint.topic = "points";
  endpoint.type_name = type_->name();
  endpoint.type_hash = type_->hash();
  endpoint.may_use_shm = plan.may_use_shm;
  endpoint.may_use_udp = plan.may_use_udp;
  endpoint.qos = plan.qos;
  if (plan.may_use_udp) endpoint.addresses = {{static_cast<std::uint32_t>(node.place), 7000, 1 << 20}};
  if (plan.role == Role::reader) {
    const FieldMask mask = type_->closed(FieldMask::from_words(type_->leaves(), {{std::uint64_t{1}}}));
    endpoint.request = {.reader = endpoint.id,
                        .sequence = 1,
                        .mask_words = mask.to_words(),
                        .listening = {},
                        .attached = {},
                        .begun = {}};
    node.readers[endpoint.id].endpoint = endpoint;
  } else {
    node.writers[endpoint.id].endpoint = endpoint;
  }
  node.negotiation.local_added(endpoint, *type_);
  const auto n = static_cast<std::size_t>(&node - nodes_.data());
  if (plan.role == Role::reader) note_request(node.negotiation, endpoint.id);
  changed(n, true);
  announce(n, endpoint.id);
}

void NegotiationWorld::kill(std::size_t n) {
  nodes_[n].up = false;
  std::erase_if(channels_, [n](const auto& c) { return c.first.second == n; });
  for (Node& node : nodes_) {
    for (auto& [id, reader] : node.readers) {
      std::erase_if(reader.fed, [&](Id writer) { return nodes_[n].writers.contains(writer); });
    }
  }
}

void NegotiationWorld::depart(std::size_t n, std::size_t which) {
  Node& node = nodes_[n];
  const bool is_writer = which < node.writers.size();
  const Id id =
      is_writer
          ? std::next(node.writers.begin(), static_cast<std::ptrdiff_t>(which))->first
          : std::next(node.readers.begin(), static_cast<std::ptrdiff_t>(which - node.writers.size()))->first;
  node.negotiation.local_removed(id);
  node.writers.erase(id);
  node.readers.erase(id);
  forget_history(node, id);
  node.announced.erase(id);
  node.sent.erase(id);
  for (auto& [ends, c] : channels_) {
    if (ends.first == n && c.found) post(c, {id, nullptr});
  }
  for (Node& other : nodes_) {
    for (auto& [reader_id, reader] : other.readers) std::erase(reader.fed, id);
  }
  changed(n, true);
}

void NegotiationWorld::change_mask(std::size_t n, std::size_t which) {
  const Id id = std::next(nodes_[n].readers.begin(), static_cast<std::ptrdiff_t>(which))->first;
  const std::uint64_t was = asked_[id].back().request.mask_words.front();
  const std::uint64_t bits = random_ != nullptr ? (*random_)() : std::uint64_t{was == 1 ? 2U : 1U};
  const FieldMask mask = FieldMask::from_words(type_->leaves(), {{bits}});  // whoever serves it closes it
  const bool is_new = nodes_[n].negotiation.requirement_changed(id, mask);
  if (!is_new) return;
  note_request(nodes_[n].negotiation, id);
  changed(n, is_new);
  send_request(n, id);
}

void NegotiationWorld::change_rate(std::size_t n, std::size_t which) {
  const Id id = std::next(nodes_[n].readers.begin(), static_cast<std::ptrdiff_t>(which))->first;
  const std::uint32_t was = asked_[id].back().request.min_period_us;
  const bool is_new = nodes_[n].negotiation.rate_changed(id, was == 0 || coin() ? was + 1000 : 0);
  if (!is_new) return fail("another rate is the same");
  note_request(nodes_[n].negotiation, id);
  changed(n, is_new);
  send_request(n, id);
}

/// Negotiation::self_changed and what Reconciler::look_after_memory does then.
void NegotiationWorld::change_memory(std::size_t n, const HostToken& host) {
  Node& node = nodes_[n];
  node.self.host = host;
  const bool dirty = node.negotiation.self_changed(node.self);
  for (auto& [id, writer] : node.writers) {
    writer.port = false;
    for (Node& other : nodes_) {
      for (auto& [reader_id, reader] : other.readers) std::erase(reader.fed, id);
    }
  }
  for (auto& [id, reader] : node.readers) {
    reader.subscribed.clear();
    reader.fed.clear();
    for (auto& [writer, heard] : reader.heard) heard.memory = false;
    note_request(node.negotiation, id);
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

// Samples.

void NegotiationWorld::publish(std::size_t n, std::size_t which) {
  const auto& [id, writer] = *std::next(nodes_[n].writers.begin(), static_cast<std::ptrdiff_t>(which));
  for (const Route& route : writer.in_force.network) datagrams_.push_back({id, route.reader, route.mask});
}

/// The datagram names its mask, so it is decoded under that mask. The check is that its reader takes such
/// samples.
void NegotiationWorld::arrive(std::size_t which) {
  const Datagram datagram = datagrams_[which];
  datagrams_.erase(datagrams_.begin() + static_cast<std::ptrdiff_t>(which));
  for (const Node& node : nodes_) {
    const auto reader = node.readers.find(datagram.reader);
    if (!node.up || reader == node.readers.end()) continue;
    if (holds(reader->second.let_go, datagram.writer)) continue;
    if (!holds(reader->second.connected, datagram.writer))
      fail("a sample came to a reader that does not listen");
    const auto& asked = asked_.at(datagram.reader);
    const bool known =
        std::any_of(asked.begin(), asked.end(), [&](const Asked& a) { return a.mask == datagram.mask; });
    if (!known) fail("a sample came under a mask that its reader never asked for");
  }
}

bool NegotiationWorld::owes_history(const Writer& writer) {
  const auto is_late = [](const Route& route) { return route.history != 0; };
  return std::ranges::any_of(writer.in_force.memory, is_late) ||
         std::ranges::any_of(writer.in_force.network, [&](const Route& route) {
           return is_late(route) && !writer.history_given.contains(route.reader);
         });
}

/// All that a writer is giving at present has left: Reconciler::look_after_histories.
void NegotiationWorld::give_history(std::size_t n, std::size_t which) {
  Node& node = nodes_[n];
  auto& [id, writer] = *std::next(node.writers.begin(), static_cast<std::ptrdiff_t>(which));
  bool dirty = false;
  for (const Route& route : writer.in_force.memory) {
    if (route.history != 0) history_comes(id, route.reader, TransportKind::shm);
  }
  for (const Route& route : writer.in_force.network) {
    if (route.history == 0) continue;
    history_comes(id, route.reader, TransportKind::udp);
    if (has_begun(node, id, route.reader)) writer.history_given.insert(route.reader);
    dirty |= node.negotiation.history_given(id, route.reader);
  }
  changed(n, dirty);
}

/// Something of that writer comes for that reader alone, if it is still there and listens.
void NegotiationWorld::history_comes(Id writer, Id reader, TransportKind path) {
  const bool over_network = path == TransportKind::udp;
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    const auto here = nodes_[n].readers.find(reader);
    if (!nodes_[n].up || here == nodes_[n].readers.end() ||
        !holds(over_network ? here->second.connected : here->second.fed, writer))
      continue;
    const Request& said = nodes_[n].negotiation.local(reader)->request;
    if (!holds(over_network ? said.listening : said.attached, writer)) continue;
    if (!nodes_[n].negotiation.history_began(reader, writer)) continue;
    note_request(nodes_[n].negotiation, reader);
    changed(n, true);
    send_request(n, reader);
  }
}

/// Returns true if the reader has told the node so.
bool NegotiationWorld::has_begun(const Node& node, Id writer, Id reader) const {
  if (const auto own = node.readers.find(reader); own != node.readers.end())
    return holds(node.negotiation.local(reader)->request.begun, writer);
  const auto told = node.told.find(reader);
  if (told == node.told.end() || told->second.endpoint == nullptr) return false;
  return holds(asked_.at(reader).at(told->second.newest).request.begun, writer);
}

/// A reader that lost a writer and found it again begins anew.
void NegotiationWorld::owe_what_has_not_begun(Node& node, Id reader) {
  for (auto& [id, writer] : node.writers) {
    if (!has_begun(node, id, reader)) writer.history_given.erase(reader);
  }
}

/// A reader that comes again after it went is another one as far as its writers can tell.
void NegotiationWorld::forget_history(Node& node, Id reader) {
  for (auto& [id, writer] : node.writers) writer.history_given.erase(reader);
}

}  // namespace sft::test
