#include "tools/sft/why.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "tools/sft/describe.h"
#include "tools/sft/one_topic.h"
#include "tools/sft/units.h"

namespace sft::tool {

namespace {

using Json = nlohmann::ordered_json;

std::string sent_text(const EndpointInfo& publisher) {
  if (!publisher.progress) return "nothing was told yet";
  return fmt::format("{} to its readers so far, {} over the network",
                     count_text(publisher.progress->samples, "sample"),
                     bytes_text(static_cast<double>(publisher.progress->bytes)));
}

void print_mismatch(const PairInfo& pair, const WhyOptions& options, Output& output) {
  if (!pair.mismatch) return;
  output.line("    here: the publisher's definition; there: the subscriber's");
  if (!options.types) return;
  output.write("    the publisher has\n" + pair.mismatch->here);
  output.write("    the subscriber has\n" + pair.mismatch->there);
}

void print_pair(const PairInfo& pair, const OneTopic& topic, const WhyOptions& options, Output& output) {
  const EndpointInfo& publisher = *endpoint_of(pair.publisher, topic.publishers);
  const EndpointInfo& subscriber = *endpoint_of(pair.subscriber, topic.subscribers);
  const Color color = !pair.matched ? Color::red : pair.connected ? Color::green : Color::yellow;
  output.line(output.colored(printable(publisher.node + " -> " + subscriber.node), Color::bold) +
              output.colored(fmt::format("  ({} -> {})", hex_text(publisher.id), hex_text(subscriber.id)),
                             Color::dim));
  output.line("    " + output.colored(printable(verdict_text(pair)), color));
  print_mismatch(pair, options, output);
  if (pair.matched) {
    output.line("    fields     " + printable(request_text(subscriber)));
    output.line("    sent       " + sent_text(publisher));
    return;
  }
  output.line("    offered    " + qos_text(publisher.qos));
  output.line("    requested  " + qos_text(subscriber.qos));
  if (!pair.no_path) return;
  output.line("    publisher  may use " + ways_text(publisher));
  output.line("    subscriber may use " + ways_text(subscriber));
}

void print_text(const OneTopic& topic, const WhyOptions& options, Output& output) {
  output.line(fmt::format("{}: {}, {}", output.colored(topic.name, Color::bold),
                          count_text(topic.publishers.size(), "publisher"),
                          count_text(topic.subscribers.size(), "subscriber")));
  for (const PairInfo& pair : topic.pairs) print_pair(pair, topic, options, output);
  if (topic.publishers.empty()) output.line("Nobody publishes it.");
  if (topic.subscribers.empty()) output.line("Nobody subscribes to it.");
  const bool some_match = std::ranges::any_of(topic.pairs, &PairInfo::matched);
  if (some_match)
    output.line(
        output.colored("Only the two nodes of a pair count what was saved, withheld or lost:\n"
                       "node.snapshot() tells it there.",
                       Color::dim));
}

void print_json(const OneTopic& topic, Output& output) {
  Json pairs = Json::array();
  for (const PairInfo& pair : topic.pairs) {
    pairs.push_back(pair_json(pair, *endpoint_of(pair.publisher, topic.publishers),
                              *endpoint_of(pair.subscriber, topic.subscribers)));
  }
  output.document({{"topic", topic.name},
                   {"publishers", topic.publishers.size()},
                   {"subscribers", topic.subscribers.size()},
                   {"pairs", std::move(pairs)}});
}

}  // namespace

ExitCode run(const WhyOptions& options, const CommonOptions& common, Session& session) {
  const Result<OneTopic> topic = look_at(options.topic, common, session);
  if (!topic) return give_up(topic.error());
  common.json ? print_json(*topic, session.output()) : print_text(*topic, options, session.output());
  const bool all_match = std::ranges::all_of(topic->pairs, &PairInfo::matched);
  return all_match && !topic->pairs.empty() ? ExitCode::done : ExitCode::nothing;
}

}  // namespace sft::tool
