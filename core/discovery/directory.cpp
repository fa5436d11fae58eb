#include "core/discovery/directory.h"

#include <algorithm>
#include <iterator>
#include <set>

#include "core/control/described_type.h"
#include "core/control/record_body.h"

namespace sft::core {

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

void Directory::give_all(const DiscoveryEvent& event) {
  for (const auto& node : nodes_) give(node, event);
}

/// The refusals come first, so that they are counted before what came after them is seen.
std::vector<DiscoveryEvent> Directory::take_events(ListeningNode& node) {
  std::vector<DiscoveryEvent> events;
  for (auto& [kind, refused] : std::exchange(node.refused, {})) events.emplace_back(std::move(refused));
  std::ranges::move(node.events, std::back_inserter(events));
  node.events.clear();
  node.is_woken = false;
  return events;
}

bool Directory::concerns(const ListeningNode& node, const Endpoint& endpoint) {
  return node.hears_all[endpoint.role] || node.topics[other(endpoint.role)].contains(endpoint.topic);
}

/// Notifies each node that the endpoint of the entry concerns.
void Directory::notify(const Entry& entry, const DiscoveryEvent& event) {
  for (const auto& node : nodes_) {
    if (node != entry.node && concerns(*node, *entry.endpoint)) give(node, event);
  }
}

void Directory::hear_all(const std::shared_ptr<ListeningNode>& node, Role role) {
  if (node->hears_all[role]) return;
  for (const auto& [id, place] : owners_) {
    const Entry& entry = entries_.at(place);
    if (entry.node != node && entry.endpoint->role == role && !concerns(*node, *entry.endpoint))
      give(node, seen(place, entry));
  }
  node->hears_all[role] = true;
}

/// Returns the entry of an endpoint of our own nodes; null if none of them has announced it.
Directory::Entry* Directory::own(EndpointId id) {
  const auto owner = owners_.find(id);
  if (owner == owners_.end()) return nullptr;
  Entry& entry = entries_.at(owner->second);
  return entry.node == nullptr ? nullptr : &entry;
}

/// Returns true if the id of the endpoint in the slot belongs to this slot.
bool Directory::owns(const Place& place, const Entry& entry) const {
  const auto owner = entry.endpoint ? owners_.find(entry.endpoint->id) : owners_.end();
  return owner != owners_.end() && owner->second == place;
}

void Directory::announced(const std::shared_ptr<ListeningNode>& node, Endpoint endpoint) {
  Entry* entry = own(endpoint.id);
  const bool is_new = entry == nullptr;
  if (is_new) {
    end_of_others(endpoint.id);
    const Place place{0, endpoint.role, own_slots_made_++};
    owners_[endpoint.id] = place;
    entry = &entries_[place];
    entry->node = node;
  } else if (entry->endpoint->request.sequence > endpoint.request.sequence) {
    endpoint.request = entry->endpoint->request;
  }
  const Endpoint& ours = entry->endpoint.emplace(std::move(endpoint));
  const Place& ours_at = owners_.at(ours.id);
  notify(*entry, seen(ours_at, *entry));
  if (!is_new) return;
  topics_[{ours.role, ours.topic}].emplace(ours.id, ours_at);
  for (const auto& [id, place] : not_heard(node, other(ours.role), ours.topic))
    give(node, seen(place, entries_.at(place)));
  ++node->topics[ours.role][ours.topic];
}

bool Directory::requested(const Request& request) {
  Entry* const entry = own(request.reader);
  if (entry == nullptr) return false;
  entry->endpoint->request = request;
  notify(*entry, request);
  return true;
}

/// A node without endpoints on a topic is not notified of changes to other nodes' endpoints on this topic.
/// So it must not keep these endpoints, and is notified that they have departed.
std::optional<Role> Directory::withdrawn(EndpointId id) {
  if (own(id) == nullptr) return std::nullopt;
  const auto ended = entries_.extract(owners_.at(id));
  const auto& [endpoint, request, node] = ended.mapped();
  end(ended.key(), ended.mapped(), EndpointDeparted{id});
  auto& topics = node->topics[endpoint->role];
  const auto topic = topics.find(endpoint->topic);
  if (--topic->second > 0) return endpoint->role;
  topics.erase(topic);
  for (const auto& [other_id, place] : not_heard(node, other(endpoint->role), endpoint->topic))
    give(node, EndpointDeparted{other_id});
  return endpoint->role;
}

std::vector<EndpointId> Directory::endpoints_of(const std::shared_ptr<ListeningNode>& node) const {
  std::vector<EndpointId> ids;
  for (const auto& [id, place] : owners_) {
    if (entries_.at(place).node == node) ids.push_back(id);
  }
  return ids;
}

void Directory::record_changed(const RecordChanged& changed) {
  const Place place{changed.process, changed.role, changed.key.slot};
  if (changed.key.kind == RecordKind::announcement) take_announcement(place, changed.record);
  if (changed.key.kind == RecordKind::request) take_request(place, changed.record);
  if (changed.key.kind == RecordKind::inquiry) take_inquiry(place, changed.record);
  const auto entry = entries_.find(place);
  if (entry != entries_.end() && !entry->second.endpoint && !entry->second.request) entries_.erase(entry);
}

void Directory::take_announcement(const Place& place, const Record& record) {
  Entry& entry = entries_[place];
  const Entry before{.endpoint = std::move(entry.endpoint)};
  entry.endpoint = announcement_in(record, std::get<Role>(place));
  const bool is_same = before.endpoint && entry.endpoint && entry.endpoint->id == before.endpoint->id &&
                       entry.endpoint->topic == before.endpoint->topic;
  if (!is_same && owns(place, before)) end(place, before, EndpointDeparted{before.endpoint->id});
  show(place);
}

/// Returns nothing if the endpoint was withdrawn, or is refused. If only its type description is malformed,
/// the endpoint has none: programs that were compiled with the type do not need it.
std::optional<Endpoint> Directory::announcement_in(const Record& record, Role role) {
  if (record.is_withdrawn()) return std::nullopt;
  Result<Endpoint> endpoint = endpoint_in(*record.body);
  if (!endpoint || endpoint->role != role) {
    log_news(News::malformed,
             endpoint ? "an endpoint on the topic of the other role" : endpoint.error().message);
    return std::nullopt;
  }
  if (endpoint->type_description.empty()) return *std::move(endpoint);
  if (const auto type = described_type(*endpoint); !type) {
    log_news(News::malformed, type.error().message);
    endpoint->type_description.clear();
  }
  return *std::move(endpoint);
}

/// The slot may have belonged to another subscriber before, whose request is still in the slot.
void Directory::take_request(const Place& place, const Record& record) {
  Entry& entry = entries_[place];
  entry.request.reset();
  if (record.is_withdrawn()) return;
  Result<Request> read = request_in(*record.body);
  if (!read) return log_news(News::malformed, read.error().message);
  entry.request = std::move(*read);
  if (!owns(place, entry) || entry.request->reader != entry.endpoint->id) return show(place);
  entry.endpoint->request = *entry.request;
  notify(entry, *entry.request);
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
  const auto found = entries_.find(place);
  if (found == entries_.end() || !found->second.endpoint) return;
  auto& [endpoint, request, node] = found->second;
  const bool has_request = request && request->reader == endpoint->id;
  if (endpoint->role == Role::reader && !has_request) return;
  const auto [owner, is_new] = owners_.try_emplace(endpoint->id, place);
  if (owner->second != place)
    return log_news(News::malformed, "an endpoint under the id of another process's, which lives");
  std::size_t& share = shares_[{std::get<ProcessId>(place), endpoint->role, endpoint->topic}];
  if (is_new && share >= topic_share) {
    owners_.erase(owner);
    return log_news(News::too_much, "endpoints of a process that has as many on one topic as it may");
  }
  share += is_new ? 1 : 0;
  if (is_new) topics_[{endpoint->role, endpoint->topic}].emplace(endpoint->id, place);
  if (has_request) endpoint->request = *request;
  notify(found->second, seen(place, found->second));
}

EndpointSeen Directory::seen(const Place& place, const Entry& entry) const {
  auto shown = std::make_shared<Endpoint>(*entry.endpoint);
  leave_out_what_is_cut(std::get<ProcessId>(place), shown->addresses);
  return shown;
}

/// Called when the endpoint is not in its slot any more; `entry` is the former one. Then notifies nodes of an
/// endpoint of another process that has announced the same id, and was refused before.
void Directory::end(const Place& place, const Entry& entry, const DiscoveryEvent& event) {
  const Endpoint& endpoint = *entry.endpoint;
  owners_.erase(endpoint.id);
  const auto topic = topics_.find({endpoint.role, endpoint.topic});
  if (topic != topics_.end() && topic->second.erase(endpoint.id) > 0 && topic->second.empty())
    topics_.erase(topic);
  const auto share = shares_.find({std::get<ProcessId>(place), endpoint.role, endpoint.topic});
  if (share != shares_.end() && --share->second == 0) shares_.erase(share);
  notify(entry, event);
  const auto has_id = [&](const auto& item) {
    return item.second.endpoint && item.second.endpoint->id == endpoint.id;
  };
  const auto of_others = entries_.lower_bound(Place{1, Role::writer, 0});
  if (const auto next = std::find_if(of_others, entries_.end(), has_id); next != entries_.end())
    show(next->first);
}

void Directory::end_of_others(EndpointId id) {
  for (auto owner = owners_.find(id); owner != owners_.end(); owner = owners_.find(id)) {
    const Place place = owner->second;
    const Entry former{.endpoint = std::exchange(entries_.at(place).endpoint, std::nullopt)};
    end(place, former, EndpointDeparted{id});
  }
}

void Directory::peer_lost(ProcessId process) {
  cut_.erase(process);
  std::erase_if(inquiries_, [&](const auto& item) { return std::get<ProcessId>(item.first) == process; });
  std::map<Place, Entry> lost;
  for (auto next = entries_.lower_bound(Place{process, Role::writer, 0});
       next != entries_.end() && std::get<ProcessId>(next->first) == process;)
    lost.insert(entries_.extract(next++));
  for (const auto& [place, entry] : lost) {
    if (owns(place, entry)) end(place, entry, EndpointLost{entry.endpoint->id});
  }
}

void Directory::paths_cut(const PathsCut& cut) {
  cut_[cut.process] = cut;
  for (const auto& [place, entry] : entries_) {
    if (std::get<ProcessId>(place) == cut.process && owns(place, entry)) show(place);
  }
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
    const auto owner = owners_.find(id);
    return owner == owners_.end() || !is_of(owner->second);
  };
  std::erase_if(report.living, is_foreign);
  std::erase_if(report.progress, [&](const Progress& one) { return is_foreign(one.writer); });
  std::erase_if(report.accounts, [&](const Account& one) {
    return is_foreign(one.id.said_by == Role::writer ? one.id.pair.writer : one.id.pair.reader);
  });
  if (report.empty()) return;
  const bool is_urgent = !report.living.empty();  // because of leases
  for (const auto& node : nodes_) {
    if (node == by || node->inquiries.empty()) continue;
    node->events.emplace_back(report);
    if (is_urgent || node->events.size() >= unread_max) wake(node);
  }
}

void Directory::report_came(ProcessId process, NodeReport report) {
  notify_report(std::move(report), nullptr,
                [&](const Place& place) { return std::get<ProcessId>(place) == process; });
}

void Directory::reported(const std::shared_ptr<ListeningNode>& node, const NodeReport& report) {
  notify_report(report, node, [&](const Place& place) { return entries_.at(place).node == node; });
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

/// Returns the endpoints on a topic that the node has not, and that it is not notified of.
std::map<EndpointId, Directory::Place> Directory::not_heard(const std::shared_ptr<ListeningNode>& node,
                                                            Role role, const std::string& topic) const {
  const auto known = topics_.find({role, topic});
  if (known == topics_.end()) return {};
  std::map<EndpointId, Place> found = known->second;
  std::erase_if(found, [&](const auto& item) {
    const Entry& entry = entries_.at(item.second);
    return entry.node == node || concerns(*node, *entry.endpoint);
  });
  return found;
}

void Directory::log_news(News news, const std::string& text) {
  const DiscoveryNews event{.kind = news, .text = text};
  if (news != News::malformed && news != News::too_much) return give_all(event);
  for (const auto& node : nodes_) {
    if (const auto [before, is_first] = node->refused.try_emplace(news, event); !is_first)
      ++before->second.times;
  }
}

std::vector<Discovery::KnownPublisher> Directory::publishers_of(std::string_view type_name) const {
  std::vector<Discovery::KnownPublisher> publishers;
  for (const auto& [id, place] : owners_) {
    const Endpoint& one = *entries_.at(place).endpoint;
    if (one.role == Role::writer && one.type_name == type_name) publishers.push_back({one.topic, one.node});
  }
  return publishers;
}

}  // namespace sft::core
