#include "tools/sft/ls.h"

#include <fmt/format.h>

#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "tools/sft/describe.h"
#include "tools/sft/msg_text.h"
#include "tools/sft/table.h"
#include "tools/terminal/units.h"

namespace sft::tool {

namespace {

using Json = nlohmann::ordered_json;

struct NodeEntry {
  std::string name;
  bool is_dds = false;
  std::set<std::string> publishes;
  std::set<std::string> subscribes;
};

struct TopicEntry {
  std::set<std::string> types;
  std::size_t publishers = 0, subscribers = 0;
  /// The number of these endpoints that belong to programs without SFT
  std::size_t dds_publishers = 0, dds_subscribers = 0;
};

/// The nodes, topics and types of a domain, each once and in order.
struct Inventory {
  std::map<std::pair<std::string, std::uint64_t>, NodeEntry> nodes;
  std::map<std::string, TopicEntry> topics;
  /// The topics of each type, which has a name and a hash.
  std::map<std::pair<std::string, std::string>, std::set<std::string>> types;

  explicit Inventory(const DomainSnapshot& domain) {
    for (const DomainSnapshot::Endpoint& e : domain.publishers) add(e, true);
    for (const DomainSnapshot::Endpoint& e : domain.subscribers) add(e, false);
  }

 private:
  void add(const DomainSnapshot::Endpoint& e, bool publishes) {
    NodeEntry& node = nodes[{e.node, e.node_id}];
    node.name = e.node;
    node.is_dds = e.dds.has_value();
    (publishes ? node.publishes : node.subscribes).insert(e.topic);
    TopicEntry& topic = topics[e.topic];
    topic.types.insert(ros_name(e.type_name));
    ++(publishes ? topic.publishers : topic.subscribers);
    if (e.dds) ++(publishes ? topic.dds_publishers : topic.dds_subscribers);
    types[{ros_name(e.type_name), type_hash_text(e)}].insert(e.topic);
  }
};

std::string joined(const std::set<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text.empty() ? "-" : text;
}

Json nodes_json(const Inventory& inventory) {
  Json list = Json::array();
  for (const auto& [id, node] : inventory.nodes) {
    list.push_back({{"id", hex_text(id.second)},
                    {"name", node.name},
                    {"dds", node.is_dds},
                    {"publishes", node.publishes},
                    {"subscribes", node.subscribes}});
  }
  return list;
}

Json topics_json(const Inventory& inventory) {
  Json list = Json::array();
  for (const auto& [name, topic] : inventory.topics) {
    list.push_back({{"name", name},
                    {"types", topic.types},
                    {"publishers", topic.publishers},
                    {"subscribers", topic.subscribers},
                    {"dds_publishers", topic.dds_publishers},
                    {"dds_subscribers", topic.dds_subscribers}});
  }
  return list;
}

Json types_json(const Inventory& inventory) {
  Json list = Json::array();
  for (const auto& [type, topics] : inventory.types)
    list.push_back({{"name", type.first}, {"hash", type.second}, {"topics", topics}});
  return list;
}

Json endpoints_json(const DomainSnapshot& domain) {
  Json list = Json::array();
  for (const DomainSnapshot::Endpoint& e : domain.publishers) list.push_back(endpoint_json(e, true));
  for (const DomainSnapshot::Endpoint& e : domain.subscribers) list.push_back(endpoint_json(e, false));
  return list;
}

void print_json(const std::string& what, const DomainSnapshot& domain, std::uint32_t number, Output& output) {
  const Inventory inventory(domain);
  Json json;
  json["domain"] = number;
  if (what.empty() || what == "nodes") json["nodes"] = nodes_json(inventory);
  if (what.empty() || what == "topics") json["topics"] = topics_json(inventory);
  if (what.empty() || what == "types") json["types"] = types_json(inventory);
  if (what.empty() || what == "endpoints") json["endpoints"] = endpoints_json(domain);
  output.document(json);
}

std::string number_text(std::size_t all, std::size_t of_dds) {
  return of_dds == 0 ? std::to_string(all) : fmt::format("{} ({} DDS)", all, of_dds);
}

Table topics_table(const Inventory& inventory) {
  Table table({"TOPIC", "TYPE", "PUBLISHERS", "SUBSCRIBERS"});
  for (const auto& [name, topic] : inventory.topics)
    table.add({name, joined(topic.types), number_text(topic.publishers, topic.dds_publishers),
               number_text(topic.subscribers, topic.dds_subscribers)});
  return table;
}

Table table_of(const std::string& what, const DomainSnapshot& domain) {
  const Inventory inventory(domain);
  if (what == "nodes") {
    Table table({"NODE", "PUBLISHES", "SUBSCRIBES TO"});
    for (const auto& [id, node] : inventory.nodes)
      table.add({node.name, joined(node.publishes), joined(node.subscribes)});
    return table;
  }
  if (what == "types") {
    Table table({"TYPE", "HASH", "TOPICS"});
    for (const auto& [type, topics] : inventory.types) table.add({type.first, type.second, joined(topics)});
    return table;
  }
  if (what != "endpoints") return topics_table(inventory);
  Table table({"ID", "ROLE", "NODE", "TOPIC", "WAYS"});
  for (const DomainSnapshot::Endpoint& e : domain.publishers)
    table.add({hex_text(e.id), "publisher", e.node, e.topic, ways_text(e)});
  for (const DomainSnapshot::Endpoint& e : domain.subscribers)
    table.add({hex_text(e.id), "subscriber", e.node, e.topic, ways_text(e)});
  return table;
}

void print_names(const std::string& what, const DomainSnapshot& domain, Output& output) {
  const Inventory inventory(domain);
  std::set<std::string> names;
  if (what == "nodes") {
    for (const auto& [id, node] : inventory.nodes) names.insert(node.name);
  } else if (what == "types") {
    for (const auto& [type, topics] : inventory.types) names.insert(type.first);
  } else if (what == "endpoints") {
    for (const auto* endpoints : {&domain.publishers, &domain.subscribers})
      for (const DomainSnapshot::Endpoint& e : *endpoints) names.insert(hex_text(e.id));
  } else {
    for (const auto& [name, topic] : inventory.topics) names.insert(name);
  }
  for (const std::string& name : names) output.line(name);
}

}  // namespace

ExitCode run(const LsOptions& options, const CommonOptions& common, Session& session) {
  const DomainSnapshot domain = session.look_around();
  const bool found = !domain.publishers.empty() || !domain.subscribers.empty();
  const std::uint32_t number = session.node().status().domain;
  Output& output = session.output();
  if (common.json) {
    print_json(options.what, domain, number, output);
  } else if (!found) {
    complain(fmt::format(
        "No publisher and no subscriber was found in domain {}; 'sft doctor' checks this host{}{}.", number,
        common.peers.empty() ? "" : "; ", common.peers.empty() ? "" : peers_name_each_other));
  } else if (options.names) {
    print_names(options.what, domain, output);
  } else {
    output.line(output.colored(fmt::format("domain {}", number), Color::dim));
    table_of(options.what, domain).print(output);
  }
  return found ? ExitCode::done : ExitCode::nothing;
}

}  // namespace sft::tool
