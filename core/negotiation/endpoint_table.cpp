#include "core/negotiation/endpoint_table.h"

#include <algorithm>

namespace sft::core {

void EndpointTable::add_ours(const Endpoint& endpoint, const TypeSupport& type) {
  const auto [entry, is_new] = entries_.insert_or_assign(
      endpoint.id, TableEntry{.endpoint = endpoint, .type = &type, .arrival = ++arrivals_});
  index(entry->second);
}

void EndpointTable::enter(const Endpoint& endpoint) {
  const auto [at, is_new] = entries_.try_emplace(endpoint.id);
  TableEntry& entry = at->second;
  if (is_new) {
    entry.arrival = ++arrivals_;
  } else {
    unindex(entry);
  }
  entry.endpoint = endpoint;
  entry.lost_since.reset();
  lost_.erase(endpoint.id);
  index(entry);
}

bool EndpointTable::erase(EndpointId id) {
  const auto gone = entries_.find(id);
  if (gone == entries_.end()) return false;
  unindex(gone->second);
  lost_.erase(id);
  entries_.erase(gone);
  return true;
}

void EndpointTable::index(const TableEntry& entry) {
  Topic& topic = topics_[entry.endpoint.topic];
  topic.endpoints.insert(entry.endpoint.id);
  topic.ours += entry.is_ours() ? 1 : 0;
}

void EndpointTable::unindex(const TableEntry& entry) {
  const auto topic = topics_.find(entry.endpoint.topic);
  topic->second.endpoints.erase(entry.endpoint.id);
  topic->second.ours -= entry.is_ours() ? 1 : 0;
  if (topic->second.endpoints.empty()) topics_.erase(topic);
}

const TableEntry* EndpointTable::find(EndpointId id) const {
  const auto entry = entries_.find(id);
  return entry == entries_.end() ? nullptr : &entry->second;
}

TableEntry* EndpointTable::find(EndpointId id) {
  const auto entry = entries_.find(id);
  return entry == entries_.end() ? nullptr : &entry->second;
}

const TableEntry* EndpointTable::find_ours(EndpointId id) const {
  const TableEntry* const entry = find(id);
  return entry != nullptr && entry->is_ours() ? entry : nullptr;
}

TableEntry* EndpointTable::find_ours(EndpointId id) {
  TableEntry* const entry = find(id);
  return entry != nullptr && entry->is_ours() ? entry : nullptr;
}

std::vector<Endpoint*> EndpointTable::ours() {
  std::vector<Endpoint*> endpoints;
  for (auto& [id, entry] : entries_) {
    if (entry.is_ours()) endpoints.push_back(&entry.endpoint);
  }
  return endpoints;
}

std::vector<const TableEntry*> EndpointTable::counterparts(const TableEntry& entry) const {
  std::vector<const TableEntry*> found;
  for (const EndpointId id : topics_.at(entry.endpoint.topic).endpoints) {
    const TableEntry& other = entries_.at(id);
    if (other.endpoint.role != entry.endpoint.role) found.push_back(&other);
  }
  return found;
}

bool EndpointTable::is_topic_of_ours(std::string_view topic) const {
  const auto known = topics_.find(topic);
  return known != topics_.end() && known->second.ours > 0;
}

bool EndpointTable::lost(EndpointId id, Time now) {
  TableEntry* const entry = find(id);
  if (entry == nullptr || entry->is_ours() || entry->lost_since) return false;
  entry->lost_since = now;
  lost_.insert(id);
  return true;
}

std::vector<EndpointId> EndpointTable::lost_for(std::chrono::seconds duration, Time now) const {
  std::vector<EndpointId> lost;
  for (const EndpointId id : lost_) {
    const TableEntry& entry = entries_.at(id);
    if (now - *entry.lost_since >= duration) lost.push_back(id);
  }
  return lost;
}

void EndpointTable::progressed(const Progress& progress) {
  TableEntry* const entry = find(progress.writer);
  if (entry != nullptr && entry->endpoint.role == Role::writer) entry->progress = progress;
}

std::vector<const TableEntry*> EndpointTable::present() const {
  std::vector<const TableEntry*> entries;
  for (const auto& [id, entry] : entries_) {
    if (!entry.lost()) entries.push_back(&entry);
  }
  return entries;
}

}  // namespace sft::core
