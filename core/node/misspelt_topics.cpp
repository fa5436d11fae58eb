#include "core/node/misspelt_topics.h"

#include <algorithm>

#include "core/names/names.h"
#include "sft/detail/text.h"

namespace sft::core {

namespace {

constexpr std::chrono::seconds longest_pause{640};

std::string in_lower_case(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return lower;
}

std::string without_digits(std::string_view text) {
  std::string rest(text);
  std::erase_if(rest, [](char c) { return c >= '0' && c <= '9'; });
  return rest;
}

bool is_end_of(std::string_view end, std::string_view topic) {
  return topic.ends_with("/" + std::string(end));
}

bool subscribes(NodeId node, const std::string& topic, const EndpointTable& table) {
  return std::ranges::any_of(table.present(), [&](const TableEntry* entry) {
    const Endpoint& e = entry->endpoint;
    return e.role == Role::reader && e.node_id == node && e.topic == topic;
  });
}

}  // namespace

bool is_similar_topic(std::string_view a, std::string_view b) {
  constexpr std::size_t long_name = 6;
  const std::string one = in_lower_case(a), other = in_lower_case(b);
  if (a == b || (one != other && without_digits(one) == without_digits(other))) return false;
  if (is_end_of(one, other) || is_end_of(other, one)) return true;
  const std::size_t most = std::min(one.size(), other.size()) < long_name ? 1 : 2;
  const std::size_t longer = std::max(one.size(), other.size()), shorter = std::min(one.size(), other.size());
  return longer - shorter <= most && detail::edit_distance(one, other) <= most;
}

std::vector<std::string> MisspeltTopics::look(const EndpointTable& table, const PublishersOf& publishers_of,
                                              Time now) {
  std::vector<std::string> sentences;
  std::erase_if(unpublished_, [&](const auto& item) {
    if (now < item.second.at) return false;
    const TableEntry* const entry = table.find_ours(item.first);
    if (entry == nullptr || !table.counterparts(*entry).empty()) return true;
    // Publishers of DDS are not in the table.
    return std::ranges::any_of(publishers_of(entry->endpoint.type_name), [entry](const auto& publisher) {
      return publisher.topic == entry->endpoint.topic;
    });
  });
  for (auto& [reader, next] : unpublished_) {
    if (now < next.at) continue;
    next.pause = std::min(next.pause * 2, longest_pause);
    next.at = now + next.pause;
    const Endpoint& ours = table.find_ours(reader)->endpoint;
    for (const auto& [topic, node] : publishers_of(ours.type_name)) {
      if (!is_similar_topic(ours.topic, topic) || subscribes(ours.node_id, topic, table)) continue;
      sentences.push_back("topic " + in_quotes(ours.topic) + ": no publisher of it was seen; did you mean " +
                          in_quotes(topic) + ", which node " + in_quotes(node) +
                          " publishes with the same type?");
      break;
    }
  }
  return sentences;
}

}  // namespace sft::core
