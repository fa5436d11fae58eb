#include "core/node/control_monitor.h"

#include <utility>

#include "core/control/names.h"

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

void ControlMonitor::name_misspelt_topics(const MisspeltTopics::PublishersOf& publishers_of, Time now) {
  for (const std::string& sentence : misspelt_topics_.look(table_, publishers_of, now))
    log_.write(LogLevel::warning, sentence);
}

void ControlMonitor::name_second_servers(const MisspeltTopics::PublishersOf& publishers_of, Time now) {
  if (now < look_at_servers_at_) return;
  look_at_servers_at_ = now + look_at_servers_every;
  std::set<std::string> found;
  for (const Endpoint* const ours : table_.present()) {
    if (table_.find_ours(ours->id) == nullptr || service_of(*ours).empty()) continue;
    std::multiset<std::string> nodes;
    for (const auto& [topic, node] : publishers_of(ours->type_name))
      if (topic == ours->topic) nodes.insert(in_quotes(node));
    if (nodes.size() < 2) continue;
    std::string names;
    for (const std::string& node : nodes) names += (names.empty() ? "" : ", ") + node;
    found.insert("service " + in_quotes(service_of(*ours)) + " has " + std::to_string(nodes.size()) +
                 " servers, on the nodes " + names + ", and clients call none of them: end all but one");
  }
  for (const std::string& sentence : found)
    if (second_servers_.contains(sentence)) log_.write(LogLevel::warning, sentence);
  second_servers_ = std::move(found);
}

}  // namespace sft::core
