#include "tools/sft/top.h"

#include <fmt/format.h>

#include <chrono>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "tools/sft/account_text.h"
#include "tools/sft/describe.h"
#include "tools/sft/one_for_each.h"
#include "tools/sft/one_topic.h"
#include "tools/sft/screen.h"
#include "tools/sft/traffic.h"
#include "tools/terminal/units.h"

namespace sft::tool {

namespace {

using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds key_pause{100};  // the pause between two readings of the domain; a key
                                                     // ends the pause earlier

struct View {
  std::uint32_t number;  ///< the number of the domain
  DomainSnapshot domain{};
  Traffic traffic{};
};

std::set<std::string> topics_of(const DomainSnapshot& domain) {
  std::set<std::string> names;
  for (const auto* endpoints : {&domain.publishers, &domain.subscribers})
    for (const DomainSnapshot::Endpoint& e : *endpoints) names.insert(e.topic);
  return names;
}

std::size_t count_nodes(const DomainSnapshot& domain) {
  std::set<std::uint64_t> nodes;
  for (const auto* endpoints : {&domain.publishers, &domain.subscribers})
    for (const DomainSnapshot::Endpoint& e : *endpoints) nodes.insert(e.node_id);
  return nodes.size();
}

std::optional<Traffic::Rate> rate_of(const OneTopic& topic, const Traffic& traffic, Clock::time_point now) {
  std::optional<Traffic::Rate> sum;
  for (const DomainSnapshot::Endpoint& publisher : topic.publishers) {
    const auto rate = traffic.of(publisher.id, now);
    if (!rate) continue;
    if (!sum) sum = Traffic::Rate{};
    sum->samples_per_s += rate->samples_per_s;
    sum->bytes_per_s += rate->bytes_per_s;
  }
  return sum;
}

Screen::Line topic_line(const OneTopic& topic, const std::optional<Traffic::Rate>& rate) {
  return {fmt::format("{:<36.36} {:>4} {:>4} {:>11} {:>14}", printable(topic.name), topic.publishers.size(),
                      topic.subscribers.size(), rate ? rate_text(rate->samples_per_s) : "-",
                      rate ? bytes_text(rate->bytes_per_s) + "/s" : "-"),
          Color::bold};
}

Screen::Line pair_line(const DomainSnapshot::Pair& pair, const OneTopic& topic) {
  const DomainSnapshot::Endpoint& publisher = *endpoint_of(pair.publisher, topic.publishers);
  const DomainSnapshot::Endpoint& subscriber = *endpoint_of(pair.subscriber, topic.subscribers);
  const std::string names = publisher.node + " -> " + subscriber.node;
  if (pair.connected) {  // wider terminals also show the text that follows the columns
    return {printable(fmt::format("{}  {}: {}", account_columns(names, to_string(pair.transport), pair),
                                  pair.reason, request_text(subscriber)))};
  }
  return {printable(fmt::format("  {:<30} {}", names, verdict_text(pair))),
          pair.matched ? Color::yellow : Color::red};
}

std::vector<Screen::Line> page(const View& view, Clock::time_point now) {
  const std::set<std::string> topics = topics_of(view.domain);
  std::vector<Screen::Line> lines;
  lines.push_back({fmt::format(
      "sft top: domain {}, {}, {}, {}; q ends", view.number, count_text(count_nodes(view.domain), "node"),
      count_text(topics.size(), "topic"), count_text(view.domain.pairs.size(), "pair"))});
  lines.push_back({fmt::format("{:<36} {:>4} {:>4} {:>11} {:>14}", "TOPIC", "PUBS", "SUBS", "SENT", "BY UDP"),
                   Color::cyan});
  lines.push_back({account_headings(), Color::cyan});
  for (const std::string& name : topics) {
    const OneTopic topic = part_of(view.domain, name);
    lines.push_back(topic_line(topic, rate_of(topic, view.traffic, now)));
    for (const DomainSnapshot::Pair& pair : topic.pairs) lines.push_back(pair_line(pair, topic));
  }
  return lines;
}

Json json_of(const View& view, Clock::time_point now) {
  Json topics = Json::array();
  for (const std::string& name : topics_of(view.domain)) {
    const OneTopic topic = part_of(view.domain, name);
    const auto rate = rate_of(topic, view.traffic, now);
    Json pairs = Json::array();
    for (const DomainSnapshot::Pair& pair : topic.pairs) {
      pairs.push_back(pair_json(pair, *endpoint_of(pair.publisher, topic.publishers),
                                *endpoint_of(pair.subscriber, topic.subscribers)));
    }
    topics.push_back({{"topic", name},
                      {"publishers", topic.publishers.size()},
                      {"subscribers", topic.subscribers.size()},
                      {"samples_per_s", rate ? Json(rate->samples_per_s) : Json()},
                      {"bytes_per_s", rate ? Json(rate->bytes_per_s) : Json()},
                      {"pairs", std::move(pairs)}});
  }
  return {{"domain", view.number}, {"nodes", count_nodes(view.domain)}, {"topics", std::move(topics)}};
}

/// Runs until the user wants to stop. The domain is read more often than it is shown, since the intervals
/// between readings limit the precision of rates.
template <class Show>
void watch(const TopOptions& options, Session& session, const Screen* screen, Show show) {
  View view{session.node().status().domain};
  std::map<std::string, AccountInquiry> inquiries;  // one for each topic
  const auto begun = Clock::now();
  for (auto next = begun; !session.stop().requested();) {
    const auto now = Clock::now();
    view.domain = session.domain();
    view.traffic.note(view.domain, now);
    keep_one_for_each(topics_of(view.domain), inquiries,
                      [&](const std::string& topic) { return session.node().ask_accounts(topic); });
    if (now >= next) {
      show(view, now);
      next = now + seconds(options.every_s);
    }
    if (options.for_s > 0 && now - begun >= seconds(options.for_s)) return;
    session.stop().wait_for(key_pause, screen == nullptr ? -1 : screen->keys().descriptor());
    if (screen != nullptr && screen->keys().pressed('q')) return;
  }
}

}  // namespace

ExitCode run(const TopOptions& options, const CommonOptions& common, Session& session) {
  Output& output = session.output();
  if (common.json) {
    watch(options, session, nullptr,
          [&](const View& view, Clock::time_point now) { output.record(json_of(view, now)); });
    return ExitCode::done;
  }
  if (!output.on_terminal()) {
    complain("The standard output of 'sft top' is no terminal; 'sft top --json' writes for programs.");
    return ExitCode::failed;
  }
  Screen screen(output);
  watch(options, session, &screen,
        [&](const View& view, Clock::time_point now) { screen.show(page(view, now)); });
  return ExitCode::done;
}

}  // namespace sft::tool
