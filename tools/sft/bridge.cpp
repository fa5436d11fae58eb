#include "tools/sft/bridge.h"

#include <fmt/format.h>
#include <sys/epoll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <list>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <tuple>

#include "tools/sft/bridge_flow.h"
#include "tools/sft/definitions.h"
#include "tools/sft/session.h"
#include "tools/terminal/units.h"

namespace sft::tool {

namespace {

using SteadyClock = std::chrono::steady_clock;
using Json = nlohmann::ordered_json;
using namespace std::chrono_literals;

constexpr auto bridge_look_pause = 100ms;
constexpr auto bridge_report_pause = 1s;
constexpr auto incomplete_after = 5s;
constexpr std::size_t complaints_most = 1'000;

/// The counts of one rule while the bridge runs.
struct RuleAccount {
  BridgeFlow::Counts counts{};
  /// The last time at which publishers and readers were seen
  SteadyClock::time_point complete = SteadyClock::now();
};

class Bridge {
 public:
  Bridge(const BridgePlan& plan, const BridgeOptions& options, const CommonOptions& common,
         std::array<BridgeEnd, 2> ends, Stop& stop, Output& output)
      : plan_(plan),
        options_(options),
        common_(common),
        stop_(stop),
        output_(output),
        ends_(std::move(ends)),
        accounts_(plan.rules.size()),
        epoll_(epoll_create1(EPOLL_CLOEXEC)) {}
  ~Bridge() {
    flows_.clear();
    close(epoll_);
  }
  Bridge(const Bridge&) = delete;
  Bridge& operator=(const Bridge&) = delete;

  void run();
  void summarize();
  bool has_failed() const { return failed_; }
  bool has_carried() const {
    return std::ranges::any_of(accounts_, [](const RuleAccount& one) { return one.counts.carried > 0; });
  }

 private:
  /// A topic that a rule carries: the index of the rule, the topic, and the name and the hash of its
  /// publishers' type.
  using Known = std::tuple<std::size_t, std::string, std::string, std::uint64_t>;

  void look();
  void look_for_topics();
  void add_flow(std::size_t rule, const std::string& topic, const Result<DynamicType>& type);
  bool is_named_by_another(const BridgeRule& rule, const std::string& topic) const;
  void carry();
  void report();
  void report_missing();
  void name_missing(const BridgeRule& rule);
  Json json_of(std::size_t rule) const;
  /// Prints the sentence with its details, unless the sentence was printed before with any details, or too
  /// many sentences were printed.
  void complain_once(const std::string& sentence, const std::string& details = {}) {
    if (complaints_.size() < complaints_most && complaints_.insert(sentence).second)
      complain(printable(sentence + details));
  }
  static std::string on(const BridgeEnd& end) { return "on side '" + end.name + "'"; }

  const BridgePlan& plan_;
  const BridgeOptions& options_;
  const CommonOptions& common_;
  Stop& stop_;
  Output& output_;
  std::array<BridgeEnd, 2> ends_;
  std::vector<RuleAccount> accounts_;  ///< one for each rule
  const int epoll_;
  std::list<BridgeFlow> flows_{};
  std::set<Known> known_{};
  std::set<std::string> complaints_{};
  std::uint64_t reported_bytes_ = 0;
  const SteadyClock::time_point begin_ = SteadyClock::now();
  bool failed_ = false;
};

/// Returns true if a rule without a pattern names the topic itself. Rules with a pattern do not carry such
/// topics.
bool Bridge::is_named_by_another(const BridgeRule& rule, const std::string& topic) const {
  return rule.is_pattern() && std::ranges::any_of(plan_.rules, [&](const BridgeRule& other) {
           return other.from == rule.from && other.topic == topic;
         });
}

void Bridge::add_flow(std::size_t rule, const std::string& topic, const Result<DynamicType>& type) {
  const BridgeRule& one = plan_.rules[rule];
  const auto refuse = [&](const Error& error) {
    complain_once(fmt::format("rule '{}': topic '{}' is not carried: {}", one.text, topic, error.message));
  };
  if (!type) return refuse(type.error());
  const bool is_there = std::ranges::any_of(flows_, [&](const BridgeFlow& flow) {
    return &flow.rule() == &one && flow.topic() == topic && flow.type_hash() == type->hash();
  });
  if (is_there) return;
  Result<BridgeFlow> flow =
      BridgeFlow::open(one, topic, *one.target_of(topic), *type, epoll_, accounts_[rule].counts);
  if (flow) {
    flows_.push_back(*std::move(flow));
    return;
  }
  refuse(flow.error());
  failed_ |= flows_.empty();  // a wrong selection ends the command, unless other topics are carried
}

void Bridge::look_for_topics() {
  std::set<Known> seen;
  for (std::size_t i = 0; i < plan_.rules.size(); ++i) {
    const BridgeRule& rule = plan_.rules[i];
    for (const DomainSnapshot::Endpoint& publisher : ends_[rule.from].domain.publishers) {
      if (publisher.is_own || publisher.topic == bridge_topic || !rule.target_of(publisher.topic)) continue;
      if (is_named_by_another(rule, publisher.topic)) continue;
      const auto [known, is_new] = seen.emplace(i, publisher.topic, publisher.type_name, publisher.type_hash);
      if (!is_new || known_.contains(*known)) continue;
      add_flow(i, publisher.topic,
               publisher.type ? Result<DynamicType>(*publisher.type) : definition_of(publisher, common_));
    }
  }
  known_ = std::move(seen);
}

void Bridge::look() {
  const auto now = SteadyClock::now();
  for (BridgeEnd& end : ends_) {
    end.domain = end.node.domain();
    end.routes.look(end.domain, now);
  }
  look_for_topics();
  std::array<std::vector<BridgeRoutes::Route>, 2> routes;
  for (BridgeFlow& flow : flows_) {
    const BridgeRule& rule = flow.rule();
    const Result<void> done =
        flow.look(ends_[rule.from], ends_[rule.to()], now, routes[rule.from], routes[rule.to()]);
    if (!done) complain_once(fmt::format("rule '{}': {}", rule.text, done.error().message));
  }
  for (std::size_t i = 0; i < ends_.size(); ++i) ends_[i].routes.announce(std::move(routes[i]), now);
  std::erase_if(flows_, [&](const BridgeFlow& flow) { return flow.is_over(now); });
}

void Bridge::carry() {
  std::array<epoll_event, 256> events{};
  const int ready = epoll_wait(epoll_, events.data(), static_cast<int>(events.size()), 0);
  std::set<BridgeFlow*> distinct;
  for (int i = 0; i < ready; ++i)
    distinct.insert(static_cast<BridgeFlow*>(events[static_cast<std::size_t>(i)].data.ptr));
  std::vector<BridgeFlow*> flows(distinct.begin(), distinct.end());
  std::ranges::sort(flows, {}, [](const BridgeFlow* flow) {
    return std::pair(-flow->rule().options.priority, flow->sample_bytes());
  });
  for (BridgeFlow* const flow : flows) {
    flow->carry();
    if (const std::string fault = flow->take_fault(); !fault.empty())
      complain_once(fmt::format("rule '{}': a sample of '{}' is left out: {}", flow->rule().text,
                                flow->topic(), fault));
  }
}

void Bridge::report_missing() {
  const auto now = SteadyClock::now();
  for (std::size_t i = 0; i < plan_.rules.size(); ++i) {
    const BridgeRule& rule = plan_.rules[i];
    const bool is_complete = std::ranges::any_of(flows_, [&](const BridgeFlow& flow) {
      return &flow.rule() == &rule && flow.state().carried > 0 && flow.state().read > 0;
    });
    if (is_complete) accounts_[i].complete = now;
    if (now - accounts_[i].complete >= incomplete_after) name_missing(rule);
  }
}

void Bridge::name_missing(const BridgeRule& rule) {
  BridgeEnd &from = ends_[rule.from], &to = ends_[rule.to()];
  bool has_publishers = false;
  for (const BridgeFlow& flow : flows_) {
    const BridgeFlow::State state = flow.state();
    if (state.publishers > 0 && flow.rule().text == rule.text) has_publishers = true;
    if (&flow.rule() != &rule || state.publishers == 0) continue;
    if (state.carried == 0 && state.is_held_by_another)
      complain_once(fmt::format("rule '{}': another bridge carries '{}' to side '{}'; this one waits",
                                rule.text, flow.topic(), to.name));
    if (state.carried > 0 && state.read == 0 && !rule.is_pattern())
      complain_once(
          fmt::format("rule '{}': '{}' has no subscriber {} yet", rule.text, flow.target(), on(to)));
  }
  if (has_publishers) return;
  std::string hint;
  if (!rule.is_pattern()) {
    if (const auto type = from.node.find_type("/" + rule.topic, 0ns); !type)
      hint = ": " + type.error().message;
  }
  complain_once(fmt::format("rule '{}': topic '{}' has no publisher {} yet", rule.text, rule.topic, on(from)),
                hint);
}

Json Bridge::json_of(std::size_t rule) const {
  const BridgeFlow::Counts& counts = accounts_[rule].counts;
  return {{"rule", plan_.rules[rule].text},
          {"from", ends_[plan_.rules[rule].from].name},
          {"carried", counts.carried},
          {"bytes", counts.bytes},
          {"lost", counts.lost},
          {"refused", counts.refused}};
}

void Bridge::report() {
  report_missing();
  const double time_s = std::chrono::duration<double>(SteadyClock::now() - begin_).count();
  if (common_.json) {
    Json rules = Json::array();
    for (std::size_t i = 0; i < accounts_.size(); ++i) rules.push_back(json_of(i));
    return output_.record({{"time_s", time_s}, {"rules", std::move(rules)}});
  }
  if (!output_.on_terminal()) return;
  BridgeFlow::Counts sum;
  std::size_t topics = 0;
  for (const RuleAccount& one : accounts_) {
    sum.carried += one.counts.carried;
    sum.bytes += one.counts.bytes;
    sum.lost += one.counts.lost;
    sum.refused += one.counts.refused;
  }
  for (const BridgeFlow& flow : flows_) topics += flow.state().carried > 0 ? 1 : 0;
  const double rate = static_cast<double>(sum.bytes - reported_bytes_) /
                      std::chrono::duration<double>(bridge_report_pause).count();
  reported_bytes_ = sum.bytes;
  output_.write(fmt::format("\r{:.0f} s, {}, {} carried, {}/s, {} lost, {} refused\x1b[K", time_s,
                            count_text(topics, "topic"), count_text(sum.carried, "sample"), bytes_text(rate),
                            sum.lost, sum.refused));
}

void Bridge::run() {
  auto next_look = begin_;
  auto next_report = begin_ + bridge_report_pause;
  while (!stop_.requested() && !failed_) {
    const auto now = SteadyClock::now();
    if (options_.for_s > 0 && now - begin_ >= seconds(options_.for_s)) break;
    carry();  // samples are taken before look() changes the routes
    if (now >= next_look) {
      look();
      next_look = now + bridge_look_pause;
    }
    if (now >= next_report) {
      report();
      next_report = now + bridge_report_pause;
    }
    stop_.wait_for(bridge_look_pause, epoll_);
  }
}

void Bridge::summarize() {
  if (output_.on_terminal() && !common_.json) output_.write("\n");
  Json rules = Json::array();
  for (std::size_t i = 0; i < accounts_.size(); ++i) {
    const BridgeFlow::Counts& counts = accounts_[i].counts;
    rules.push_back(json_of(i));
    if (common_.json) continue;
    output_.line(
        printable(fmt::format("{} (from '{}'): {} carried, {}, {} lost, {} refused", plan_.rules[i].text,
                              ends_[plan_.rules[i].from].name, count_text(counts.carried, "sample"),
                              bytes_text(static_cast<double>(counts.bytes)), counts.lost, counts.refused)));
  }
  if (common_.json) output_.record({{"rules", std::move(rules)}});
}

ExitCode refuse(const Error& error) {
  complain(printable(error.message));
  return ExitCode::failed;
}

/// Sets the priorities of rules of the command line from the texts of the option, TOPIC=NUMBER.
Result<void> prioritize(std::vector<BridgeRule>& rules, const std::vector<std::string>& priorities) {
  for (const std::string& text : priorities) {
    const std::size_t equals = std::min(text.find('='), text.size());
    const std::string topic = Session::plain_name(text.substr(0, equals));
    std::int8_t priority = 0;
    const char* const end = text.data() + text.size();
    const char* const number = text.data() + std::min(equals + 1, text.size());
    const auto [rest, fault] = std::from_chars(number, end, priority);
    const bool is_number = fault == std::errc() && rest == end && number != end;
    if (!is_number || priority < -bridge_priority_most || priority > bridge_priority_most) {
      return fail(Errc::invalid_argument,
                  fmt::format("'{}' is no priority: write TOPIC=NUMBER, with a number from -{} to {}", text,
                              bridge_priority_most, bridge_priority_most));
    }
    bool is_used = false;
    for (BridgeRule& rule : rules) {
      if (rule.topic != topic) continue;
      rule.options.priority = priority;
      is_used = true;
    }
    if (!is_used)
      return fail(Errc::invalid_argument, "--priority " + text + ": no rule has the topic '" + topic + "'");
  }
  return {};
}

Result<BridgePlan> plan_of(const BridgeOptions& options, const CommonOptions& common) {
  BridgePlan plan;
  BridgeSide &first = plan.sides[0], &second = plan.sides[1];
  first.node.domain = common.domain;
  first.node.discovery.interfaces = common.interfaces;
  first.node.discovery.peers = common.peers;
  first.node.vanilla_dds = vanilla_choice_of(options.from_dds);
  second.node.domain = options.to;
  second.node.discovery.interfaces = options.to_interfaces;
  second.node.discovery.peers = options.to_peers;
  second.node.vanilla_dds = vanilla_choice_of(options.to_dds);
  if (!options.file.empty()) {
    if (const Result<void> read = read_bridge_file(options.file, plan); !read)
      return tl::unexpected(read.error());
  }
  for (const std::string& text : options.rules) {
    const Result<std::vector<BridgeRule>> ways = parse_bridge_rule(text, options.each);
    if (!ways) return tl::unexpected(ways.error());
    plan.rules.insert(plan.rules.end(), ways->begin(), ways->end());
  }
  if (plan.rules.empty())
    return fail(Errc::invalid_argument,
                "name rules, such as 'points -> robot/points': nothing passes without one");
  if (const Result<void> prioritized = prioritize(plan.rules, options.priorities); !prioritized)
    return tl::unexpected(prioritized.error());
  return check_rules(plan.rules).map([&] { return plan; });
}

Result<BridgeEnd> open_end(const BridgeSide& side, std::uint64_t bridge) {
  NodeOptions options = side.node;
  options.name = bridge_node_prefix + std::to_string(getpid());
  options.shm.start_daemon = false;
  Result<Node> node = Node::open(options);
  if (!node) return tl::unexpected(node.error());
  Result<BridgeRoutes> routes = BridgeRoutes::open(*node, bridge);
  if (!routes) return tl::unexpected(routes.error());
  DomainSnapshot domain = node->domain();  // from now on the node discovers all publishers
  const std::string name = side.name.empty() ? "domain " + std::to_string(node->status().domain) : side.name;
  return BridgeEnd{name, options.name, *std::move(node), *std::move(routes), std::move(domain)};
}

}  // namespace

ExitCode run(const BridgeOptions& options, const CommonOptions& common, Stop& stop, Output& output) {
  const Result<BridgePlan> plan = plan_of(options, common);
  if (!plan) return refuse(plan.error());
  const auto bridge = static_cast<std::uint64_t>(std::chrono::system_clock::now().time_since_epoch().count());
  Result<BridgeEnd> first = open_end(plan->sides[0], bridge);
  if (!first) return refuse(first.error());
  Result<BridgeEnd> second = open_end(plan->sides[1], bridge);
  if (!second) return refuse(second.error());
  const std::uint32_t domain = first->node.status().domain;
  if (domain == second->node.status().domain) {
    return refuse(
        {Errc::invalid_argument,
         fmt::format("both sides are in domain {}, and a bridge would carry what it brings: give the "
                     "sides different domains (--from, --to)",
                     domain)});
  }
  Bridge work(*plan, options, common, {*std::move(first), *std::move(second)}, stop, output);
  work.run();
  work.summarize();
  if (work.has_failed()) return ExitCode::failed;
  return work.has_carried() ? ExitCode::done : ExitCode::nothing;
}

}  // namespace sft::tool
