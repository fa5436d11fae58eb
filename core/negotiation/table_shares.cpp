#include "core/negotiation/table_shares.h"

#include <algorithm>

namespace sft::core {

bool TableShares::has_room(AnnouncerId announcer, std::string_view topic) const {
  const auto found = topics_.find(topic);
  if (found == topics_.end() || found->second.entries < limits_.topic_shares_from) return true;
  const auto own = found->second.of.find(announcer);
  return own == found->second.of.end() || own->second < limits_.of_topic;
}

TableShares::Admission TableShares::admit(AnnouncerId announcer, std::string_view topic) const {
  if (!has_room(announcer, topic)) return {};
  if (entries_.size() < limits_.entries) return {.granted = true};
  const std::size_t own = of(announcer);
  const auto most =
      std::ranges::max_element(announcers_, {}, [](const auto& item) { return item.second.size(); });
  if (own >= limits_.of_announcer || most == announcers_.end() || own + 1 > most->second.size() ||
      most->first == announcer)
    return {};
  return {.granted = true, .instead_of = most->second.rbegin()->second};
}

void TableShares::enter(EndpointId id, AnnouncerId announcer, std::string_view topic) {
  remove(id);
  const std::uint64_t arrival = ++arrivals_;
  entries_[id] = {announcer, arrival, std::string(topic)};
  announcers_[announcer][arrival] = id;
  Topic& of_topic = topics_[std::string(topic)];
  ++of_topic.entries;
  ++of_topic.of[announcer];
}

void TableShares::remove(EndpointId id) {
  const auto entry = entries_.find(id);
  if (entry == entries_.end()) return;
  const auto& [announcer, arrival, topic] = entry->second;
  const auto own = announcers_.find(announcer);
  own->second.erase(arrival);
  if (own->second.empty()) announcers_.erase(own);
  const auto of_topic = topics_.find(topic);
  if (--of_topic->second.of.at(announcer) == 0) of_topic->second.of.erase(announcer);
  if (--of_topic->second.entries == 0) topics_.erase(of_topic);
  entries_.erase(entry);
}

std::size_t TableShares::of(AnnouncerId announcer) const {
  const auto found = announcers_.find(announcer);
  return found == announcers_.end() ? 0 : found->second.size();
}

const AnnouncerId* TableShares::announcer_of(EndpointId id) const {
  const auto found = entries_.find(id);
  return found == entries_.end() ? nullptr : &found->second.announcer;
}

}  // namespace sft::core
