#include "core/node/second_servers.h"

#include <algorithm>
#include <iterator>
#include <string_view>
#include <utility>

#include "core/names/names.h"

namespace sft::core {

namespace {
constexpr std::chrono::seconds look_at_servers_every{8};

/// Returns the name of the service if the endpoint is its publisher of replies (sft/service.h), otherwise an
/// empty text.
std::string_view service_of(const Endpoint& e) {
  constexpr std::string_view end = "/reply";
  const bool is_of_service = e.role == Role::writer && e.topic.ends_with(end) &&
                             e.type_name.ends_with("_Reply") &&
                             e.type_name.find("::srv::") != std::string::npos;
  return is_of_service ? std::string_view(e.topic).substr(0, e.topic.size() - end.size()) : "";
}
}  // namespace

std::vector<std::string> SecondServers::look(const EndpointTable& table,
                                             const MisspeltTopics::PublishersOf& publishers_of, Time now) {
  if (now < next_) return {};
  next_ = now + look_at_servers_every;
  std::set<std::string> found;
  for (const TableEntry* const entry : table.present()) {
    const Endpoint& ours = entry->endpoint;
    if (!entry->is_ours() || service_of(ours).empty()) continue;
    std::multiset<std::string> nodes;
    for (const auto& [topic, node] : publishers_of(ours.type_name))
      if (topic == ours.topic) nodes.insert(in_quotes(node));
    if (nodes.size() < 2) continue;
    std::string names;
    for (const std::string& node : nodes) names += (names.empty() ? "" : ", ") + node;
    found.insert("service " + in_quotes(service_of(ours)) + " has " + std::to_string(nodes.size()) +
                 " servers, on the nodes " + names + ", and clients call none of them: end all but one");
  }
  std::vector<std::string> sentences;
  std::ranges::set_intersection(found, found_, std::back_inserter(sentences));
  found_ = std::move(found);
  return sentences;
}

}  // namespace sft::core
