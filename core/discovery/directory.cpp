#include "core/discovery/directory.h"

#include <algorithm>
#include <iterator>
#include <set>

#include "core/control/described_type.h"
#include "core/control/record_body.h"

namespace sft::core {

namespace {

DiscoveryEvent seen(const Endpoint& endpoint) {
  return [endpoint = std::make_shared<const Endpoint>(endpoint)](DiscoveryListener& to) {
    to.endpoint_seen(*endpoint);
  };
}

DiscoveryEvent departed(EndpointId id) {
  return [id](DiscoveryListener& to) { to.endpoint_departed(id); };
}

DiscoveryEvent received(const Request& request) {
  return [request](DiscoveryListener& to) { to.request_received(request); };
}

}  // namespace

std::shared_ptr<ListeningNode> Directory::join(std::function<void()> wake) {
  return nodes_.emplace_back(std::make_shared<ListeningNode>(ListeningNode{.wake = std::move(wake)}));
}

void Directory::wake(const std::shared_ptr<ListeningNode>& node) {
  if (!std::exchange(node->is_woken, true)) woken_.push_back(node);
}

void Directory::give(const std::shared_ptr<ListeningNode>& node, DiscoveryEvent event) {
  node->events.push_back(std::move(event));
  wake(node);
}

/// The refusals come first, so that they are counted before what came after them is seen.
std::vector<DiscoveryEvent> Directory::take_events(ListeningNode& node) {
  std::vector<DiscoveryEvent> events;
  for (auto& [news, refused] : std::exchange(node.refused, {})) {
    events.emplace_back(
        [news, refused](DiscoveryListener& to) { to.log_news(news, refused.text, refused.times); });
  }
  std::ranges::move(node.events, std::back_inserter(events));
  node.events.clear();
  node.is_woken = false;
  return events;
}

bool Directory::concerns(const ListeningNode& node, const Endpoint& endpoint) {
  return node.hears_all[endpoint.role] || node.topics[other(endpoint.role)].contains(endpoint.topic);
}

/// Notifies each node that the entry concerns.
void Directory::notify(const Entry& entry, const DiscoveryEvent& event) {
  for (const auto& node : nodes_) {
    if (node != entry.node && concerns(*node, entry.endpoint)) give(node, event);
  }
}

void Directory::hear_all(const std::shared_ptr<ListeningNode>& node, Role role) {
  if (node->hears_all[role]) return;
  for (const auto& [id, entry] : entries_) {
    const Endpoint& one = entry.endpoint;
    if (entry.node != node && one.role == role && !concerns(*node, one)) give(node, seen(one));
  }
  node->hears_all[role] = true;
}

void Directory::announced(const std::shared_ptr<ListeningNode>& node, Endpoint endpoint) {
  const auto [place, is_new] = entries_.try_emplace(endpoint.id);
  Entry& entry = place->second;
  if (entry.endpoint.request.sequence > endpoint.request.sequence) endpoint.request = entry.endpoint.request;
  entry.node = node;
  set(entry, std::move(endpoint));
  notify(entry, seen(entry.endpoint));
  if (!is_new) return;
  const Endpoint& own = entry.endpoint;
  for (const Entry* const one : on_topic(other(own.role), own.topic)) {
    if (one->node != node && !concerns(*node, one->endpoint)) give(node, seen(one->endpoint));
  }
  ++node->topics[own.role][own.topic];
}

bool Directory::requested(const Request& request) {
  const auto found = entries_.find(request.reader);
  if (found == entries_.end() || found->second.node == nullptr) return false;
  found->second.endpoint.request = request;
  notify(found->second, received(request));
  return true;
}

/// A node without endpoints on a topic is not notified of changes to other nodes' endpoints on this topic.
/// So it must not keep these endpoints, and is notified that they have departed.
std::optional<Role> Directory::withdrawn(EndpointId id) {
  const auto found = entries_.find(id);
  if (found == entries_.end() || found->second.node == nullptr) return std::nullopt;
  const std::shared_ptr<ListeningNode> node = found->second.node;
  const Role role = found->second.endpoint.role;
  auto& topics = node->topics[role];
  const auto topic = topics.find(found->second.endpoint.topic);
  end(id, departed(id));
  if (--topic->second > 0) return role;
  const std::string name = topics.extract(topic).key();
  for (const Entry* const one : on_topic(other(role), name)) {
    if (one->node != node && !concerns(*node, one->endpoint)) give(node, departed(one->endpoint.id));
  }
  return role;
}

std::vector<EndpointId> Directory::endpoints_of(const std::shared_ptr<ListeningNode>& node) const {
  std::vector<EndpointId> ids;
  for (const auto& [id, entry] : entries_) {
    if (entry.node == node) ids.push_back(id);
  }
  return ids;
}

void Directory::record_changed(const RecordChanged& changed) {
  const Place place{changed.process, changed.role, changed.key.slot};
  if (changed.key.kind == RecordKind::announcement) take_announcement(place, changed.record);
  if (changed.key.kind == RecordKind::request) take_request(place, changed.record);
  if (changed.key.kind == RecordKind::inquiry) take_inquiry(place, changed.record);
  const auto slot = slots_.find(place);
  if (slot != slots_.end() && !slot->second.endpoint && !slot->second.request) slots_.erase(slot);
}

void Directory::take_announcement(const Place& place, const Record& record) {
  std::optional<Endpoint> endpoint;
  if (!record.is_withdrawn()) {
    if (Result<Endpoint> read = endpoint_in(*record.body); !read) {
      log_news(News::malformed, read.error().message);
    } else if (read->role != std::get<Role>(place)) {
      log_news(News::malformed, "an endpoint on the topic of the other role");
    } else {
      endpoint = std::move(*read);
    }
  }
  Slot& slot = slots_[place];
  const std::optional<Endpoint> before = std::exchange(slot.endpoint, std::move(endpoint));
  const bool is_same =
      before && slot.endpoint && slot.endpoint->id == before->id && slot.endpoint->topic == before->topic;
  if (before && !is_same) {
    const auto shown = entries_.find(before->id);
    if (shown != entries_.end() && shown->second.place == place) end(before->id, departed(before->id));
  }
  show(place);
}

/// The slot may have belonged to another subscriber before, whose request is still in the slot.
void Directory::take_request(const Place& place, const Record& record) {
  Slot& slot = slots_[place];
  slot.request.reset();
  if (record.is_withdrawn()) return;
  Result<Request> read = request_in(*record.body);
  if (!read) return log_news(News::malformed, read.error().message);
  slot.request = std::move(*read);
  const auto shown = entries_.find(slot.request->reader);
  if (shown == entries_.end() || shown->second.place != place) return show(place);
  shown->second.endpoint.request = *slot.request;
  notify(shown->second, received(*slot.request));
}

void Directory::take_inquiry(const Place& place, const Record& record) {
  inquiries_.erase(place);
  if (record.is_withdrawn()) return;
  Result<Inquiry> read = inquiry_in(*record.body);
  if (!read) return log_news(News::malformed, read.error().message);
  inquiries_.emplace(place, std::move(*read));
  ++inquiries_made_;
}

/// Notifies nodes of the endpoint in the slot. The endpoint of a subscriber is shown only if its request has
/// come, too.
void Directory::show(const Place& place) {
  const auto found = slots_.find(place);
  if (found == slots_.end() || !found->second.endpoint) return;
  const auto& [endpoint, request] = found->second;
  const bool is_whole = endpoint->role == Role::writer || (request && request->reader == endpoint->id);
  if (!is_whole) return;
  const auto known = entries_.find(endpoint->id);
  if (known != entries_.end() && known->second.place != place)
    return log_news(News::malformed, "an endpoint under the id of another process's, which lives");
  if (known == entries_.end()) {
    std::size_t& share = shares_[{std::get<ProcessId>(place), endpoint->role, endpoint->topic}];
    if (share >= topic_share)
      return log_news(News::too_much, "endpoints of a process that has as many on one topic as it may");
    ++share;
  }
  Endpoint shown = *endpoint;
  if (request) shown.request = *request;
  if (!shown.type_description.empty()) {
    if (const auto type = described_type(shown); !type) {
      log_news(News::malformed, type.error().message);
      shown.type_description.clear();  // programs that were compiled with the type do not need the
                                       // description
    }
  }
  leave_out_what_is_cut(std::get<ProcessId>(place), shown.addresses);
  Entry& entry = entries_[shown.id];
  entry.place = place;
  set(entry, std::move(shown));
  notify(entry, seen(entry.endpoint));
}

void Directory::give_back_share(const Entry& entry) {
  if (!entry.place) return;
  const Endpoint& endpoint = entry.endpoint;
  const auto share = shares_.find({std::get<ProcessId>(*entry.place), endpoint.role, endpoint.topic});
  if (--share->second == 0) shares_.erase(share);
}

/// Then notifies nodes of an endpoint of another process that has announced the same id, and was refused
/// before.
void Directory::end(EndpointId id, const DiscoveryEvent& event) {
  const auto ended = entries_.extract(id);
  if (!ended) return;
  forget_topic(ended.mapped().endpoint);
  give_back_share(ended.mapped());
  notify(ended.mapped(), event);
  const auto has_id = [&](const auto& item) {
    return item.second.endpoint && item.second.endpoint->id == id;
  };
  if (const auto next = std::ranges::find_if(slots_, has_id); next != slots_.end()) show(next->first);
}

void Directory::peer_lost(ProcessId process) {
  cut_.erase(process);
  std::erase_if(inquiries_, [&](const auto& item) { return std::get<ProcessId>(item.first) == process; });
  std::vector<EndpointId> lost;
  const auto first = slots_.lower_bound(Place{process, Role::writer, 0});
  auto last = first;
  for (; last != slots_.end() && std::get<ProcessId>(last->first) == process; ++last) {
    if (!last->second.endpoint) continue;
    const auto entry = entries_.find(last->second.endpoint->id);
    if (entry != entries_.end() && entry->second.place == last->first) lost.push_back(entry->first);
  }
  slots_.erase(first, last);
  for (const EndpointId id : lost) end(id, [id](DiscoveryListener& to) { to.endpoint_lost(id); });
}

void Directory::paths_cut(const PathsCut& cut) {
  cut_[cut.process] = cut;
  std::vector<Place> places;
  for (const auto& [id, entry] : entries_) {
    if (entry.place && std::get<ProcessId>(*entry.place) == cut.process) places.push_back(*entry.place);
  }
  for (const Place& place : places) show(place);
}

/// Removes addresses by which the process is not reached, unless none would remain. If a cut link and a
/// link with heartbeats of the process lead to the same network, the addresses in that network are kept,
/// since the process may have replaced the first link by the second.
void Directory::leave_out_what_is_cut(ProcessId process, std::vector<UdpAddress>& addresses) const {
  const auto cut = cut_.find(process);
  if (cut == cut_.end()) return;
  const auto is_cut = [&](const UdpAddress& address) {
    const auto leads_there = [&](LinkId link) { return leads_to_(link, address.ip); };
    return std::ranges::any_of(cut->second.links, leads_there) &&
           std::ranges::none_of(cut->second.heard, leads_there);
  };
  if (!std::ranges::all_of(addresses, is_cut)) std::erase_if(addresses, is_cut);
}

template <class IsOf>
void Directory::notify_report(NodeReport report, const std::shared_ptr<ListeningNode>& by, IsOf is_of) {
  const auto is_foreign = [&](EndpointId id) {
    const auto entry = entries_.find(id);
    return entry == entries_.end() || !is_of(entry->second);
  };
  std::erase_if(report.living, is_foreign);
  std::erase_if(report.progress, [&](const Progress& one) { return is_foreign(one.writer); });
  std::erase_if(report.accounts, [&](const Account& one) {
    return is_foreign(one.id.said_by == Role::writer ? one.id.pair.writer : one.id.pair.reader);
  });
  if (report.empty()) return;
  const bool is_urgent = !report.living.empty();  // because of leases
  const DiscoveryEvent event = [report = std::move(report)](DiscoveryListener& to) {
    to.report_received(report);
  };
  for (const auto& node : nodes_) {
    if (node == by || node->inquiries.empty()) continue;
    node->events.push_back(event);
    if (is_urgent || node->events.size() >= unread_max) wake(node);
  }
}

void Directory::report_came(ProcessId process, NodeReport report) {
  notify_report(std::move(report), nullptr, [&](const Entry& entry) {
    return entry.place && std::get<ProcessId>(*entry.place) == process;
  });
}

void Directory::reported(const std::shared_ptr<ListeningNode>& node, const NodeReport& report) {
  notify_report(report, node, [&](const Entry& entry) { return entry.node == node; });
}

void Directory::inquires(const std::shared_ptr<ListeningNode>& node, std::set<Inquiry> inquiries) {
  node->inquiries = std::move(inquiries);
  ++inquiries_made_;
}

std::set<Inquiry> Directory::own_inquiries() const {
  std::set<Inquiry> all;
  for (const auto& node : nodes_) all.insert(node->inquiries.begin(), node->inquiries.end());
  return all;
}

Discovery::Inquiries Directory::inquiries() const {
  Discovery::Inquiries inquiries{.all = own_inquiries(), .made = inquiries_made_};
  for (const auto& [place, inquiry] : inquiries_) inquiries.all.insert(inquiry);
  return inquiries;
}

/// Gives an entry its endpoint, under whose topic on_topic() finds the entry from then on.
void Directory::set(Entry& entry, Endpoint endpoint) {
  forget_topic(entry.endpoint);
  entry.endpoint = std::move(endpoint);
  topics_[{entry.endpoint.role, entry.endpoint.topic}].insert(entry.endpoint.id);
}

void Directory::forget_topic(const Endpoint& endpoint) {
  const auto topic = topics_.find({endpoint.role, endpoint.topic});
  if (topic == topics_.end()) return;
  topic->second.erase(endpoint.id);
  if (topic->second.empty()) topics_.erase(topic);
}

std::vector<const Directory::Entry*> Directory::on_topic(Role role, const std::string& topic) const {
  std::vector<const Entry*> found;
  const auto known = topics_.find({role, topic});
  if (known == topics_.end()) return found;
  for (const EndpointId id : known->second) found.push_back(&entries_.at(id));
  return found;
}

void Directory::log_news(News news, const std::string& text) {
  for (const auto& node : nodes_) {
    if (news != News::malformed && news != News::too_much) {
      give(node, [news, text](DiscoveryListener& to) { to.log_news(news, text, 1); });
      continue;
    }
    ListeningNode::Refused& refused = node->refused[news];
    if (refused.times++ == 0) refused.text = text;
  }
}

void Directory::vanilla_changed() {
  for (const auto& node : nodes_) give(node, [](DiscoveryListener& to) { to.vanilla_changed(); });
}

std::vector<Discovery::KnownPublisher> Directory::publishers_of(std::string_view type_name) const {
  std::vector<Discovery::KnownPublisher> publishers;
  for (const auto& [id, entry] : entries_) {
    const Endpoint& one = entry.endpoint;
    if (one.role == Role::writer && one.type_name == type_name) publishers.push_back({one.topic, one.node});
  }
  return publishers;
}

}  // namespace sft::core
