#include "tools/sft/why.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <vector>

#include "tools/sft/account_text.h"
#include "tools/sft/dds_checks.h"
#include "tools/sft/describe.h"
#include "tools/sft/one_topic.h"
#include "tools/terminal/columns.h"
#include "tools/terminal/units.h"

namespace sft::tool {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t width = 80;
constexpr std::size_t indent = 4;

/// Prints the text in lines that fit a terminal, indented and coloured. Prints nothing if the text is empty.
void print_indented(const std::string& text, Color color, Output& output) {
  if (text.empty()) return;
  for (const std::string& line : lines_of(printable(text), width - indent, LongWords::broken))
    output.line(std::string(indent, ' ') + output.colored(line, color));
}

/// Prints the text in the same way, with a name before its first line. Prints nothing if the text is empty.
void print_row(const char* name, const std::string& text, Output& output) {
  if (text.empty()) return;
  constexpr std::size_t name_width = 11;
  for (const std::string& line : lines_of(printable(text), width - indent - name_width, LongWords::broken)) {
    output.line(fmt::format("{:{}}{:<{}}{}", "", indent, name, name_width, line));
    name = "";
  }
}

/// Prints the names of both nodes, with the ids of the endpoints after the names. If the line is too short
/// for this, the ids are printed below the names.
void print_ends(const DomainSnapshot::Endpoint& publisher, const DomainSnapshot::Endpoint& subscriber,
                Output& output) {
  const std::string ids = fmt::format("({} -> {})", hex_text(publisher.id), hex_text(subscriber.id));
  const std::vector<std::string> names =
      lines_of(printable(publisher.node + " -> " + subscriber.node), width, LongWords::broken);
  for (const std::string& part : names) {
    if (&part != &names.back()) {
      output.line(output.colored(part, Color::bold));
    } else if (columns_of(part) + 2 + ids.size() <= width) {
      output.line(output.colored(part, Color::bold) + "  " + output.colored(ids, Color::dim));
    } else {
      output.line(output.colored(part, Color::bold));
      print_indented(ids, Color::dim, output);
    }
  }
}

void print_mismatch(const DomainSnapshot::Pair& pair, const WhyOptions& options, Output& output) {
  if (!pair.mismatch) return;
  output.line("    here: the publisher's definition; there: the subscriber's");
  if (!options.types) return;
  output.write("    the publisher has\n" + pair.mismatch->here);
  output.write("    the subscriber has\n" + pair.mismatch->there);
}

void print_pair(const DomainSnapshot::Pair& pair, const OneTopic& topic, const WhyOptions& options,
                Output& output) {
  const DomainSnapshot::Endpoint& publisher = *endpoint_of(pair.publisher, topic.publishers);
  const DomainSnapshot::Endpoint& subscriber = *endpoint_of(pair.subscriber, topic.subscribers);
  const Color color = !pair.matched ? Color::red : pair.connected ? Color::green : Color::yellow;
  print_ends(publisher, subscriber, output);
  print_indented(verdict_text(pair), color, output);
  print_mismatch(pair, options, output);
  if (pair.matched) {
    print_row("fields", request_text(subscriber), output);
    if (!pair.dds_publisher && !pair.dds_subscriber) {
      print_row("sent", sent_text(pair), output);
      print_row("diverted", diverted_text(pair), output);
      print_row("saved", saved_text(pair), output);
      print_row("withheld", withheld_text(pair), output);
    }
    if (!pair.dds_subscriber) print_row("lost", lost_text(pair), output);
    print_indented(takes_none_text(pair), Color::red, output);
    print_indented(unanswered_text(pair), Color::red, output);
    print_indented(unreadable_text(pair), Color::red, output);
    return;
  }
  print_row("offered", qos_text(publisher.qos), output);
  print_row("requested", qos_text(subscriber.qos), output);
  if (!pair.no_path) return;
  print_row("publisher", "may use " + ways_text(publisher), output);
  print_row("subscriber", "may use " + ways_text(subscriber), output);
}

/// Returns a text for a topic on which a subscriber of SFT also receives from DDS writers. A publisher
/// cannot distinguish the DDS reader of this subscriber from other DDS readers. So a publisher that serves
/// DDS readers sends whole messages to that reader, too.
std::string text_of_whole_messages(const OneTopic& topic) {
  const auto& pairs = topic.pairs;
  const bool serves = std::ranges::any_of(
      pairs, [](const DomainSnapshot::Pair& pair) { return pair.dds_subscriber && pair.connected; });
  const bool hears = std::ranges::any_of(
      pairs, [](const DomainSnapshot::Pair& pair) { return pair.dds_publisher && pair.connected; });
  if (!serves || !hears) return {};
  return "The topic has readers and writers of DDS: so its publishers of SFT send whole messages by DDS to "
         "subscribers of SFT in other processes, too, which drop them";
}

void print_text(const OneTopic& topic, const std::vector<Finding>& findings, const WhyOptions& options,
                Output& output) {
  const std::string numbers = fmt::format("{}, {}", count_text(topic.publishers.size(), "publisher"),
                                          count_text(topic.subscribers.size(), "subscriber"));
  const std::vector<std::string> heading =
      lines_of(printable(topic.name) + ": " + numbers, width, LongWords::broken);
  for (const std::string& line : heading) output.line(output.colored(line, Color::bold));
  for (const DomainSnapshot::Pair& pair : topic.pairs) print_pair(pair, topic, options, output);
  print_indented(text_of_whole_messages(topic), Color::yellow, output);
  if (topic.publishers.empty()) output.line("Nobody publishes it.");
  if (topic.subscribers.empty()) output.line("Nobody subscribes to it.");
  for (const Finding& finding : findings)
    print_indented(finding.text + ". " + finding.to_do, Color::yellow, output);
}

void print_pairs_json(const OneTopic& topic, const std::vector<Finding>& findings, Output& output) {
  Json pairs = Json::array();
  for (const DomainSnapshot::Pair& pair : topic.pairs) {
    pairs.push_back(pair_json(pair, *endpoint_of(pair.publisher, topic.publishers),
                              *endpoint_of(pair.subscriber, topic.subscribers)));
  }
  Json out_of_reach = Json::array();
  for (const Finding& finding : findings) out_of_reach.push_back(finding.text + ". " + finding.to_do);
  const std::string whole = text_of_whole_messages(topic);
  output.document({{"topic", topic.name},
                   {"publishers", topic.publishers.size()},
                   {"subscribers", topic.subscribers.size()},
                   {"pairs", std::move(pairs)},
                   {"whole_messages_by_dds", whole.empty() ? Json() : Json(whole)},
                   {"out_of_reach", std::move(out_of_reach)}});
}

/// Returns true if all nodes of DDS have announced their readers and writers, and all nodes of SFT have
/// opened DDS endpoints for the endpoints of DDS that match on the topic.
bool dds_has_answered(const DomainSnapshot& domain, const OneTopic& topic) {
  return all_dds_nodes_have_answered(domain) &&
         std::ranges::none_of(topic.pairs, [](const DomainSnapshot::Pair& pair) {
           return (pair.dds_publisher || pair.dds_subscriber) && pair.matched && !pair.connected;
         });
}

}  // namespace

/// First asks the nodes of all pairs for their counters, since most nodes answer while the command is still
/// discovering other nodes. Samples that are under way are given time to arrive before they count as
/// missing.
ExitCode run(const WhyOptions& options, const CommonOptions& common, Session& session) {
  if (const Result<void> sound = session.check_name(options.topic); !sound) return give_up(sound.error());
  const Result<AccountInquiry> inquiry = session.node().ask_accounts(options.topic);
  if (!inquiry) return give_up(inquiry.error());
  Result<OneTopic> topic = look_at(options.topic, common, session);
  if (!topic) return give_up(topic.error());
  const auto all_are_reported = [&](const DomainSnapshot& domain) {
    topic = part_of(domain, topic->name);
    return std::ranges::all_of(topic->pairs, is_reported);
  };
  session.wait_until(all_are_reported, common.wait_s);
  const auto all_have_taken = [&](const DomainSnapshot& domain) {
    topic = part_of(domain, topic->name);
    return std::ranges::none_of(topic->pairs, takes_none);
  };
  session.wait_until(all_have_taken, 2 * common.wait_s);
  std::vector<Finding> findings;
  const auto dds_is_known = [&](const DomainSnapshot& domain) {
    topic = part_of(domain, topic->name);
    findings = check_dds(DdsEnvironment::of_process(), domain);
    return dds_has_answered(domain, *topic);
  };
  session.wait_until(dds_is_known, dds_answers_within_s);
  std::erase_if(findings, [](const Finding& finding) { return finding.health == Health::ok; });
  common.json ? print_pairs_json(*topic, findings, session.output())
              : print_text(*topic, findings, options, session.output());
  const auto is_well = [](const DomainSnapshot::Pair& pair) {
    return pair.matched && is_reported(pair) && !takes_none(pair);
  };
  const bool all_is_well = std::ranges::all_of(topic->pairs, is_well);
  return all_is_well && !topic->pairs.empty() ? ExitCode::done : ExitCode::nothing;
}

}  // namespace sft::tool
