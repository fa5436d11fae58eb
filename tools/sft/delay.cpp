#include "tools/sft/delay.h"

#include <fmt/format.h>

#include <chrono>
#include <nlohmann/json.hpp>

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

Arrivals::Request request(const std::string& field) {
  if (field.empty()) {
    return {.fields = "", .options = {.depth = 1024}, .measure = [](const DynamicSample& sample) {
              return since(sample.info().source_stamp, sample);
            }};
  }
  return {.fields = field, .options = {.depth = 1024}, .measure = [field](const DynamicSample& sample) {
            const DynamicView stamp = sample.view().find(field);
            const auto sec = stamp["sec"].as<std::int64_t>();
            const auto nanosec = stamp["nanosec"].as<std::int64_t>();
            if (!sec || !nanosec) return 0.0;
            return since(Stamp(std::chrono::seconds(*sec) + std::chrono::nanoseconds(*nanosec)), sample);
          }};
}

const char* remark(const Spread& delay) {
  constexpr double decades = 1e9;
  if (delay.max > decades) return "; the stamp is not set";
  return delay.min < 0 ? "; clocks differ" : "";
}

void print(Arrivals& arrivals, const DelayOptions& options, bool json, Output& output) {
  const Arrivals::Report report = arrivals.report(options.live.window_s);
  const Spread& delay = report.values;
  if (json) {
    return output.record(nlohmann::ordered_json{
        {"topic", arrivals.topic()},
        {"since", options.published ? "published" : "header.stamp"},
        {"delay_s",
         {{"mean", delay.mean}, {"min", delay.min}, {"max", delay.max}, {"deviation", delay.deviation}}},
        {"samples", report.samples},
        {"new", report.fresh}});
  }
  if (report.samples == 0) return output.line(arrivals.topic() + ": no sample yet");
  if (report.fresh == 0)
    return output.line(fmt::format("{}: no new sample, {} so far", arrivals.topic(), report.samples));
  const std::string text =
      fmt::format("{}: {} ({} to {}, deviation {}), {} so far{}", arrivals.topic(), duration_text(delay.mean),
                  duration_text(delay.min), duration_text(delay.max), duration_text(delay.deviation),
                  report.samples, remark(delay));
  output.line(output.fitted(text, live_indent));
}

}  // namespace

ExitCode run(const DelayOptions& options, const CommonOptions& common, Session& session) {
  const Result<FoundTopic> topic = session.find(options.topic);
  if (!topic) return give_up(topic.error());
  const std::string field = options.published ? "" : stamp_field(topic->type.support());
  if (field.empty() && !options.published) {
    complain(
        fmt::format("{} has no field header.stamp; 'sft delay --published {}' measures from its publication.",
                    topic->type.name(), topic->name));
    return ExitCode::failed;
  }
  const auto arrivals = Arrivals::open(*topic, request(field), session.node());
  if (!arrivals) return give_up(arrivals.error());
  report_every_second(options.live, session.stop(),
                      [&] { print(**arrivals, options, common.json, session.output()); });
  return (*arrivals)->report(options.live.window_s).samples > 0 ? ExitCode::done : ExitCode::nothing;
}

}  // namespace sft::tool
