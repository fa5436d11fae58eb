#include "tools/sft/hz.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "tools/sft/arrivals.h"
#include "tools/sft/publisher_counts.h"
#include "tools/terminal/units.h"

namespace sft::tool {

namespace {

std::string text_of(const std::string& topic, const Arrivals::Report& report) {
  if (report.samples == 0) return topic + ": no sample yet";
  const std::string lost = report.lost == 0 ? "" : fmt::format(", {} lost", report.lost);
  if (report.fresh == 0) return fmt::format("{}: no new sample, {} so far{}", topic, report.samples, lost);
  if (report.rate_hz == 0)
    return fmt::format("{}: {} so far{}", topic, count_text(report.samples, "sample"), lost);
  const Spread& periods = report.periods;
  return fmt::format("{}: {}, periods of {} to {}, deviation {}, {} so far{}", topic,
                     rate_text(report.rate_hz), duration_text(periods.min), duration_text(periods.max),
                     duration_text(periods.deviation), report.samples, lost);
}

std::string text_of(const std::string& topic, const PublisherCounts::Report& report) {
  if (report.samples == 0) return topic + ": its publishers have sent no sample to a subscriber yet";
  if (report.rate_hz == 0)
    return fmt::format("{}: {} sent so far", topic, count_text(report.samples, "sample"));
  return fmt::format("{}: {} sent, {} so far", topic, rate_text(report.rate_hz), report.samples);
}

/// Prints the rate according to the publishers' counts. Publishers measure no periods between samples, and
/// do not count the samples that a subscriber loses.
std::uint64_t print_rate(PublisherCounts& counts, bool json, Output& output) {
  const PublisherCounts::Report report = counts.report();
  if (json) {
    output.record(nlohmann::ordered_json{{"topic", counts.topic()},
                                         {"rate_hz", report.rate_hz},
                                         {"period_s", nullptr},
                                         {"samples", report.samples},
                                         {"new", report.fresh},
                                         {"lost", nullptr}});
  } else {
    output.line(output.fitted(text_of(counts.topic(), report), live_indent));
  }
  return report.samples;
}

void print(Arrivals& arrivals, const HzOptions& options, bool json, Output& output) {
  const Arrivals::Report report = arrivals.report(options.live.window_s);
  if (!json) return output.line(output.fitted(text_of(arrivals.topic(), report), live_indent));
  output.record(nlohmann::ordered_json{{"topic", arrivals.topic()},
                                       {"rate_hz", report.rate_hz},
                                       {"period_s",
                                        {{"mean", report.periods.mean},
                                         {"min", report.periods.min},
                                         {"max", report.periods.max},
                                         {"deviation", report.periods.deviation}}},
                                       {"samples", report.samples},
                                       {"new", report.fresh},
                                       {"lost", report.lost}});
}

}  // namespace

ExitCode run(const HzOptions& options, const CommonOptions& common, Session& session) {
  std::vector<std::unique_ptr<Arrivals>> watched;
  std::vector<std::unique_ptr<PublisherCounts>> counted;
  for (const std::string& name : options.topics) {
    const Result<FoundTopic> topic = session.find(name);
    if (!topic) {
      if (auto counts = counts_instead(name, topic.error(), session)) {
        counted.push_back(std::move(counts));
        continue;
      }
      return give_up(topic.error());
    }
    auto arrivals = Arrivals::open(*topic, {.fields = "", .options = {.depth = 1024}}, session.node());
    if (!arrivals) return give_up(arrivals.error());
    watched.push_back(std::move(*arrivals));
  }
  std::size_t sent = 0;  // the number of topics in `counted` on which a sample was sent
  report_every_second(options.live, session.stop(), [&] {
    for (const auto& arrivals : watched) print(*arrivals, options, common.json, session.output());
    sent = 0;
    for (const auto& counts : counted) sent += print_rate(*counts, common.json, session.output()) > 0 ? 1 : 0;
  });
  const bool came = std::ranges::all_of(
      watched, [&](const auto& arrivals) { return arrivals->report(options.live.window_s).samples > 0; });
  return came && sent == counted.size() ? ExitCode::done : ExitCode::nothing;
}

}  // namespace sft::tool
