// The nodes of the world tell each other things here, and these arrive or get lost.
#include <algorithm>
#include <utility>

#include "tests/simulation/negotiation/negotiation_world.h"
#include "tests/unit/core/control/endpoint_ids.h"

namespace sft::test {

using core::Endpoint;
using core::Request;
using core::Role;

void NegotiationWorld::announce(std::size_t n, Id id) {
  auto endpoint = std::make_shared<const Endpoint>(*nodes_[n].negotiation.local(id));
  nodes_[n].announced[id] = endpoint;
  for (auto& [ends, c] : channels_) {
    if (ends.first == n && c.found) post(c, {id, endpoint});
  }
}

void NegotiationWorld::send_request(std::size_t n, Id reader) {
  auto request = std::make_shared<const Request>(nodes_[n].negotiation.local(reader)->request);
  nodes_[n].sent[reader] = request;
  for (auto& [ends, c] : channels_) {
    if (ends.first == n && c.found) post(c, request);
  }
}

void NegotiationWorld::note_request(const core::Negotiation& negotiation, Id reader) {
  const Request& request = negotiation.local(reader)->request;
  const FieldMask mask = type_->closed(FieldMask::from_words(type_->leaves(), request.mask_words));
  asked_[reader].resize(request.sequence + 1, {request, mask});
}

void NegotiationWorld::post(Channel& c, Announcement announcement) {
  if (random_ == nullptr || coin()) {
    std::erase_if(c.announcements, [&](const Announcement& a) { return a.id == announcement.id; });
  }
  c.announcements.push_back(std::move(announcement));
}

void NegotiationWorld::post(Channel& c, std::shared_ptr<const Request> request) {
  if (random_ == nullptr || coin()) {
    std::erase_if(c.requests, [&](const auto& r) { return r->reader == request->reader; });
  }
  c.requests.push_back(std::move(request));
}

void NegotiationWorld::deliver(std::size_t to, const Announcement& announcement) {
  Node& node = nodes_[to];
  if (announcement.endpoint == nullptr) {
    node.told.erase(announcement.id);
    forget_history(node, announcement.id);
    return changed(to, node.negotiation.endpoint_departed(announcement.id));
  }
  Told& told = node.told[announcement.id];
  told.newest = std::max({told.newest, told.newest_while_away, announcement.endpoint->request.sequence});
  told.newest_while_away = 0;
  told.endpoint = announcement.endpoint;
  told.lost_since.reset();
  told.silent = false;
  if (told.endpoint->role == Role::reader) owe_what_has_not_begun(node, announcement.id);
  changed(to, node.negotiation.endpoint_seen(*announcement.endpoint));
}

void NegotiationWorld::deliver(std::size_t to, const Request& request) {
  Node& node = nodes_[to];
  Told& told = node.told[request.reader];
  const bool here = told.endpoint != nullptr && !told.lost();
  std::uint64_t& newest = here ? told.newest : told.newest_while_away;
  newest = std::max(newest, request.sequence);
  if (here) owe_what_has_not_begun(node, request.reader);
  changed(to, node.negotiation.request_received(request));
}

void NegotiationWorld::lose(std::size_t from, std::size_t to) {
  channel(from, to) = {};
  Node& node = nodes_[to];
  bool dirty = false;
  for (auto& [id, told] : node.told) {
    if (told.endpoint == nullptr || !holds(nodes_[from].opened, id)) continue;
    if (!told.lost_since) told.lost_since = node.now;
    dirty |= node.negotiation.endpoint_lost(id, node.now);
  }
  changed(to, dirty);
}

bool NegotiationWorld::knows_as_silent(std::size_t from, std::size_t to) const {
  return std::any_of(nodes_[to].told.begin(), nodes_[to].told.end(), [&](const auto& told) {
    return told.second.silent && holds(nodes_[from].opened, told.first);
  });
}

/// The node's signs of life get lost; everything else arrives.
void NegotiationWorld::fall_silent(std::size_t from, std::size_t to) {
  Node& node = nodes_[to];
  for (auto& [id, told] : node.told) {
    if (told.endpoint != nullptr && holds(nodes_[from].opened, id)) told.silent = true;
  }
  changed(to, node.negotiation.node_lost(nodes_[from].id));
}

void NegotiationWorld::hear_again(std::size_t from, std::size_t to) {
  Node& node = nodes_[to];
  for (auto& [id, told] : node.told) {
    if (!told.silent || !holds(nodes_[from].opened, id)) continue;
    told.silent = false;
    if (told.lost_since) continue;
    told.newest = std::max(told.newest, std::exchange(told.newest_while_away, 0));
    if (told.endpoint->role == Role::reader) owe_what_has_not_begun(node, id);
  }
  changed(to, node.negotiation.node_returned(nodes_[from].id));
}

void NegotiationWorld::find(std::size_t from, std::size_t to) {
  Channel& c = channel(from, to);
  c.found = true;
  for (const auto& [id, endpoint] : nodes_[from].announced) post(c, {id, endpoint});
  for (const auto& [id, request] : nodes_[from].sent) post(c, request);
}

void NegotiationWorld::forget(std::size_t n) {
  Node& node = nodes_[n];
  node.now += std::chrono::seconds(60);
  for (auto& [id, told] : node.told) {
    if (!told.lost_since) continue;
    told = {.endpoint = nullptr,
            .lost_since = {},
            .silent = false,
            .newest = 0,
            .newest_while_away = told.newest_while_away};
    forget_history(node, id);
  }
  changed(n, node.negotiation.tick(node.now));
}

}  // namespace sft::test
