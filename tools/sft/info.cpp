#include "tools/sft/info.h"

#include <fmt/format.h>

#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "tools/sft/describe.h"
#include "tools/sft/msg_text.h"
#include "tools/sft/one_topic.h"
#include "tools/terminal/units.h"

namespace sft::tool {

namespace {

using Json = nlohmann::ordered_json;

void print_endpoint(const DomainSnapshot::Endpoint& e, bool publishes, Output& output) {
  output.line(fmt::format("  {}  {}", output.colored(printable(e.node), Color::cyan),
                          output.colored(hex_text(e.id), Color::dim)));
  const auto print_line = [&](const char* what, const std::string& text) {
    const std::string head = fmt::format("    {:<10} ", what);
    output.line(head + output.fitted(text, head.size(), head.size()));
  };
  if (!e.given_topic.empty()) print_line("called", printable(e.given_topic) + " by its program");
  print_line("qos", qos_text(e.qos));
  if (e.dds) {
    print_line("ways", "dds: it knows nothing of SFT");
    print_line("in DDS", printable(fmt::format("{}, {}", e.dds->topic, e.dds->type_name)));
    print_line("hash", printable(type_hash_text(e)));
    return print_line("guid", e.dds->guid);
  }
  print_line("ways", fmt::format("{}, on {} machine", ways_text(e), e.same_machine ? "this" : "another"));
  std::string addresses;
  for (const std::string& address : e.addresses) addresses += (addresses.empty() ? "" : ", ") + address;
  if (!addresses.empty()) print_line("addresses", addresses);
  if (!publishes) return print_line("asks for", printable(request_text(e)));
  print_line("samples", "of at most " + bytes_text(static_cast<double>(e.max_sample_bytes)));
  if (e.waits) print_line("waits", "for reliable subscribers that do not keep up");
  if (!e.progress) return;
  print_line("sent", fmt::format("{} so far, {} over the network", count_text(e.progress->samples, "sample"),
                                 bytes_text(static_cast<double>(e.progress->bytes))));
}

void print_text(const OneTopic& topic, Output& output) {
  output.line(output.colored(topic.name, Color::bold));
  // The hashes of SFT and of ROS 2 cannot be compared. So types of DDS endpoints are compared by name.
  std::map<std::string, std::set<std::string>> types;
  bool differ = false;
  for (const auto* endpoints : {&topic.publishers, &topic.subscribers}) {
    for (const DomainSnapshot::Endpoint& e : *endpoints) {
      std::set<std::string>& hashes = types[ros_name(e.type_name)];
      if (!e.dds) hashes.insert(hex_text(e.type_hash));
      differ |= hashes.size() > 1;
    }
  }
  for (const auto& [name, hashes] : types) {
    if (hashes.empty()) output.line("  " + printable(name));
    for (const std::string& hash : hashes) output.line(fmt::format("  {}  {}", name, hash));
  }
  if (differ || types.size() > 1)
    output.line(output.colored("  These types differ, and so do not match: see 'sft why'.", Color::yellow));
  output.line(count_text(topic.publishers.size(), "publisher"));
  for (const DomainSnapshot::Endpoint& e : topic.publishers) print_endpoint(e, true, output);
  output.line(count_text(topic.subscribers.size(), "subscriber"));
  for (const DomainSnapshot::Endpoint& e : topic.subscribers) print_endpoint(e, false, output);
}

void print_json(const OneTopic& topic, Output& output) {
  Json json = {{"topic", topic.name}, {"publishers", Json::array()}, {"subscribers", Json::array()}};
  for (const DomainSnapshot::Endpoint& e : topic.publishers)
    json["publishers"].push_back(endpoint_json(e, true));
  for (const DomainSnapshot::Endpoint& e : topic.subscribers)
    json["subscribers"].push_back(endpoint_json(e, false));
  output.document(json);
}

}  // namespace

ExitCode run(const InfoOptions& options, const CommonOptions& common, Session& session) {
  const Result<OneTopic> topic = look_at(options.topic, common, session);
  if (!topic) return give_up(topic.error());
  common.json ? print_json(*topic, session.output()) : print_text(*topic, session.output());
  return ExitCode::done;
}

}  // namespace sft::tool
