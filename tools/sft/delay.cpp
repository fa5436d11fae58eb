#include "tools/sft/delay.h"

#include <fmt/format.h>

#include <atomic>
#include <chrono>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>

#include "tools/sft/arrivals.h"
#include "tools/terminal/units.h"

namespace sft::tool {

namespace {

/// Returns the path of the time stamp: "header.stamp", or "stamp" if the message itself is a header. Returns
/// an empty text if there is no time stamp.
std::string stamp_field(const TypeSupport& type) {
  for (const char* field : {"header.stamp", "stamp"}) {
    const std::string path = field;
    if (type.find(path + ".sec") && type.find(path + ".nanosec")) return path;
  }
  return {};
}

using Stamp = std::chrono::sys_time<std::chrono::nanoseconds>;

double since(Stamp stamp, const DynamicSample& sample) {
  return std::chrono::duration<double>(sample.info().receive_stamp - stamp).count();
}

/// Samples without a usable stamp since the last report. Counted on threads of the node.
struct Unusable {
  std::atomic<std::uint64_t> not_set{0};
  std::atomic<std::uint64_t> absent{0};  ///< samples without such an element
};

/// Returns the path in the form that selections use for a field of all elements:
/// "transforms[].header.stamp".
std::string of_all_elements(std::string_view field) {
  std::string path;
  bool in_brackets = false;
  for (const char c : field) {
    in_brackets = c == '[' || (in_brackets && c != ']');
    if (!in_brackets || c == '[') path += c;
  }
  return path;
}

Arrivals::Request request(const std::string& field, Unusable& unusable) {
  if (field.empty()) {
    return {.fields = "", .options = {.depth = 1024}, .measure = [](const DynamicSample& sample) {
              return since(sample.info().source_stamp, sample);
            }};
  }
  const auto measure = [field, &unusable](const DynamicSample& sample) -> std::optional<double> {
    const DynamicView stamp = sample.view().find(field);
    const auto sec = stamp["sec"].as<std::int64_t>();
    const auto nanosec = stamp["nanosec"].as<std::int64_t>();
    const bool is_there = sec && nanosec;
    const double age =
        is_there ? since(Stamp(std::chrono::seconds(*sec) + std::chrono::nanoseconds(*nanosec)), sample) : 0;
    constexpr double decades_s = 1e9;  // a stamp that was never set is near the year 1970
    if (!is_there || age > decades_s) {
      ++(is_there ? unusable.not_set : unusable.absent);
      return std::nullopt;
    }
    return age;
  };
  return {.fields = of_all_elements(field), .options = {.depth = 1024}, .measure = measure};
}

void print(Arrivals& arrivals, const std::string& field, Unusable& unusable, const DelayOptions& options,
           bool json, Output& output) {
  const Arrivals::Report report = arrivals.report(options.live.window_s);
  const Spread& delay = report.values;
  const std::uint64_t not_set = unusable.not_set.exchange(0), absent = unusable.absent.exchange(0);
  if (json) {
    return output.record(nlohmann::ordered_json{
        {"topic", arrivals.topic()},
        {"since", options.published ? "published" : field},
        {"clock", "of this host"},
        {"delay_s",
         {{"mean", delay.mean}, {"min", delay.min}, {"max", delay.max}, {"deviation", delay.deviation}}},
        {"samples", report.samples},
        {"new", report.fresh},
        {"not_set", not_set},
        {"absent", absent}});
  }
  if (report.samples == 0) return output.line(arrivals.topic() + ": no sample yet");
  if (report.fresh == 0)
    return output.line(fmt::format("{}: no new sample, {} so far", arrivals.topic(), report.samples));
  const std::string spread =
      delay.count == 0
          ? "no delay"
          : fmt::format("{} ({} to {}, deviation {})", duration_text(delay.mean), duration_text(delay.min),
                        duration_text(delay.max), duration_text(delay.deviation));
  std::string text = fmt::format("{}: {}, {} so far{}", arrivals.topic(), spread, report.samples,
                                 delay.min < 0 ? "; stamps are in the future: clocks differ" : "");
  if (not_set > 0) text += fmt::format("; not set: {} of {}", not_set, report.fresh);
  if (absent > 0) text += fmt::format("; no such element: {} of {}", absent, report.fresh);
  output.line(output.fitted(text, live_indent));
}

}  // namespace

ExitCode run(const DelayOptions& options, const CommonOptions& common, Session& session) {
  const Result<FoundTopic> topic = session.find(options.topic);
  if (!topic) return give_up(topic.error());
  const TypeSupport& type = topic->type.support();
  std::string field = options.published || !options.field.empty() ? options.field : stamp_field(type);
  const std::string known = of_all_elements(field);
  if (!options.published && (field.empty() || !type.find(known + ".sec") || !type.find(known + ".nanosec"))) {
    complain(fmt::format("{} has no {}; 'sft delay --published {}' measures from its publication.",
                         topic->type.name(),
                         options.field.empty() ? "field header.stamp: name another one with --field"
                                               : "field '" + field + "' of the type Time",
                         topic->name));
    return ExitCode::failed;
  }
  Unusable unusable;  // outlives the callbacks of the subscriber
  const auto arrivals = Arrivals::open(*topic, request(field, unusable), session.node());
  if (!arrivals) return give_up(arrivals.error());
  report_every_second(options.live, session.stop(),
                      [&] { print(**arrivals, field, unusable, options, common.json, session.output()); });
  return (*arrivals)->report(options.live.window_s).samples > 0 ? ExitCode::done : ExitCode::nothing;
}

}  // namespace sft::tool
