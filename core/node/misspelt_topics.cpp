#include "core/node/misspelt_topics.h"

#include <algorithm>

#include "core/control/names.h"
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

/// Returns the publisher of a similar topic to which the node of the reader does not subscribe as well; null
/// if there is none.
const Endpoint* similar_publisher(const Endpoint& reader, const EndpointTable& table) {
  const std::vector<const Endpoint*> endpoints = table.present();
  const auto is_subscribed_to = [&](const std::string& topic) {
    return std::ranges::any_of(endpoints, [&](const Endpoint* e) {
      return e->role == Role::reader && e->node_id == reader.node_id && e->topic == topic;
    });
  };
  const auto similar = std::ranges::find_if(endpoints, [&](const Endpoint* e) {
    return e->role == Role::writer && e->type_name == reader.type_name &&
           is_similar_topic(reader.topic, e->topic) && !is_subscribed_to(e->topic);
  });
  return similar == endpoints.end() ? nullptr : *similar;
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

std::vector<std::string> MisspeltTopics::look(const EndpointTable& table, Time now) {
  std::vector<std::string> sentences;
  std::erase_if(unpublished_, [&](const auto& item) {
    if (now < item.second.at) return false;
    const TableEntry* const entry = table.find_ours(item.first);
    return entry == nullptr || !table.counterparts(*entry).empty();
  });
  for (auto& [reader, next] : unpublished_) {
    if (now < next.at) continue;
    next.pause = std::min(next.pause * 2, longest_pause);
    next.at = now + next.pause;
    const Endpoint& ours = table.find_ours(reader)->endpoint;
    if (const Endpoint* const similar = similar_publisher(ours, table)) {
      sentences.push_back("topic " + in_quotes(ours.topic) + ": no publisher of it was seen; did you mean " +
                          in_quotes(similar->topic) + ", which node " + in_quotes(similar->node) +
                          " publishes with the same type?");
    }
  }
  return sentences;
}

}  // namespace sft::core
