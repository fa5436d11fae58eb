#include "tools/sft/perf.h"

#include <fmt/format.h>

#include <chrono>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>

#include "tools/perf/pong.h"
#include "tools/sft/message_type.h"
#include "tools/terminal/file_error.h"

namespace sft::tool {

namespace {

using namespace std::chrono_literals;

constexpr std::size_t usual_bytes = 64;

struct Message {
  DynamicType type;
  std::shared_ptr<const perf::Payload> payload;
};

/// Takes the next whole sample of a topic.
Result<Message> message_like(const std::string& topic, Session& session) {
  const Result<FoundTopic> found = session.find(topic);
  if (!found) return tl::unexpected(found.error());
  auto subscriber =
      session.node().subscriber(found->name, found->type, "*", {.durability = found->requested.durability});
  if (!subscriber) return tl::unexpected(subscriber.error());
  const auto end = std::chrono::steady_clock::now() + seconds(session.options().timeout_s);
  while (!subscriber->wait(20ms)) {
    if (session.stop().wait_for(0ns) || std::chrono::steady_clock::now() > end)
      return fail(Errc::unavailable, "no sample of '" + found->name + "' came in time");
  }
  const DynamicSample sample = subscriber->take();
  const auto bytes = sample.cdr();
  return Message{found->type, std::make_shared<const perf::Payload>(bytes.begin(), bytes.end())};
}

Result<Message> message_of(const PerfOptions& options, Session& session) {
  if (!options.like.empty()) return message_like(options.like, session);
  const std::string name = options.type.empty() ? "std_msgs/UInt8MultiArray" : options.type;
  const Result<DynamicType> type = find_message_type(name, "", session);
  if (!type) return tl::unexpected(type.error());
  const bool by_size = options.value.empty() && (options.size || options.type.empty());
  const Result<std::string> json =
      by_size ? perf::json_of_size(type->name(), options.size.value_or(usual_bytes))
              : json_from_yaml(type->type(), options.value.empty() ? "{}" : options.value);
  if (!json) return tl::unexpected(json.error());
  return cdr_from_json(type->type(), *json, {.now = std::chrono::system_clock::now()})
      .map([&](std::vector<std::byte>&& payload) {
        return Message{*type, std::make_shared<const perf::Payload>(std::move(payload))};
      });
}

/// Prints the error and returns its exit code. With --json, the error is also written to the standard
/// output, which then always contains JSON.
ExitCode give_up(const Error& error, const CommonOptions& common, Session& session) {
  if (common.json)
    session.output().document({{"error", error.message}, {"lanes", nlohmann::ordered_json::array()}});
  return tool::give_up(error);
}

ExitCode serve(const CommonOptions& common, Session& session) {
  Result<perf::Pong> pong = perf::Pong::open(session.node());
  if (!pong) return tool::give_up(pong.error());
  Output& output = session.output();
  const auto print_line = [&](const std::string& sentence) {
    if (common.json) return output.record({{"event", sentence}});
    output.line((output.on_terminal() ? "\r\x1b[K" : "") + output.fitted(printable(sentence), 4));
  };
  print_line(fmt::format("waits in domain {} for 'sft perf ping' or 'sft perf pub'",
                         session.node().status().domain));
  bool served = false;
  for (auto shown = std::chrono::steady_clock::now();
       !session.stop().wait_for(pong->pause(), pong->descriptor());) {
    for (const std::string& sentence : pong->step()) {
      served = true;
      print_line(sentence);
    }
    if (std::chrono::steady_clock::now() - shown < 1s || common.json || !output.on_terminal()) continue;
    shown = std::chrono::steady_clock::now();
    output.write("\r\x1b[K" + pong->line());
  }
  return served ? ExitCode::done : ExitCode::nothing;
}

Result<void> draw(const perf::Outcome& run, const std::string& file) {
  if (file.empty()) return {};
  std::ofstream out(file);
  out << perf::svg_of(run);
  if (out.flush()) return {};
  return tl::unexpected(cannot_be_written(file));
}

}  // namespace

ExitCode run(const PerfOptions& options, const CommonOptions& common, Session& session) {
  if (options.answers) return serve(common, session);
  std::vector<perf::Criterion> criteria;
  if (!options.fail_if.empty()) {
    auto parsed = perf::parse_criteria(options.fail_if);
    if (!parsed) return give_up(parsed.error(), common, session);
    criteria = *std::move(parsed);
  }
  const Result<Message> message = message_of(options, session);
  if (!message) return give_up(message.error(), common, session);
  Output& output = session.output();
  const bool live = output.on_terminal() && !common.json;
  perf::Plan plan = options.plan;
  plan.timeout_s = common.timeout_s;
  const auto run = perf::measure(session.node(), message->type, message->payload, plan, session.stop(),
                                 [&](const std::string& line) {
                                   if (live) output.write("\r\x1b[K" + line.substr(0, output.columns() - 1));
                                 });
  if (live) output.write("\r\x1b[K");
  if (!run) return give_up(run.error(), common, session);
  const auto failed =
      perf::failures(criteria, run->lanes.empty() ? perf::Values() : run->lanes[0].values(run->answers));
  if (common.json) {
    output.document(perf::json_of(*run, failed));
  } else {
    output.write(perf::text_of(*run));
  }
  if (const Result<void> drawn = draw(*run, options.svg); !drawn) return tool::give_up(drawn.error());
  for (const std::string& sentence : failed) complain("failed: " + sentence);
  if (!run->error.empty()) complain(run->error);
  const auto came = run->lanes.empty() ? 0 : run->lanes[0].arrived;
  if (!run->error.empty() || came == 0) return ExitCode::nothing;
  return failed.empty() ? ExitCode::done : ExitCode::unmet;
}

}  // namespace sft::tool
