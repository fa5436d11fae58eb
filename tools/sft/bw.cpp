#include "tools/sft/bw.h"

#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "tools/sft/arrivals.h"
#include "tools/sft/publisher_counts.h"
#include "tools/terminal/units.h"

namespace sft::tool {

namespace {

double bytes_of(const DynamicSample& sample) { return static_cast<double>(sample.cdr().size()); }

/// Measures the chosen fields in the size that another host would receive.
Arrivals::Request sizes(const BwOptions& options) {
  Arrivals::Request request{.fields = options.fields, .options = {.depth = 64}, .measure = bytes_of};
  request.options.recording.as_remote = options.fields != "*";
  if (!options.every) request.options.max_rate_hz = 1;
  return request;
}

std::string text_of(const std::string& topic, double bytes_per_s, const Arrivals::Report& rate,
                    const Arrivals::Report& size) {
  if (rate.samples == 0) return topic + ": no sample yet";
  if (rate.fresh == 0) return fmt::format("{}: no new sample, {} so far", topic, rate.samples);
  return fmt::format("{}: {}/s, {} of {} ({} to {}), {} so far", topic, bytes_text(bytes_per_s),
                     rate_text(rate.rate_hz), bytes_text(size.values.mean), bytes_text(size.values.min),
                     bytes_text(size.values.max), rate.samples);
}

void print(const BwOptions& options, const Arrivals::Report& rate, const Arrivals::Report& size, bool json,
           const std::string& topic, Output& output) {
  const double bytes_per_s = rate.rate_hz * size.values.mean;
  if (json) {
    return output.record(nlohmann::ordered_json{{"topic", topic},
                                                {"fields", options.fields},
                                                {"bytes_per_s", bytes_per_s},
                                                {"rate_hz", rate.rate_hz},
                                                {"sample_bytes",
                                                 {{"mean", size.values.mean},
                                                  {"min", size.values.min},
                                                  {"max", size.values.max},
                                                  {"measured", size.values.count}}},
                                                {"samples", rate.samples},
                                                {"lost", rate.lost}});
  }
  output.line(output.fitted(text_of(topic, bytes_per_s, rate, size), live_indent));
}

/// Prints the bytes per second according to the publishers' counts. Publishers do not count the bytes of
/// samples in shared memory.
std::uint64_t print_bytes(PublisherCounts& counts, bool json, Output& output) {
  const PublisherCounts::Report report = counts.report();
  if (json) {
    output.record(nlohmann::ordered_json{{"topic", counts.topic()},
                                         {"fields", nullptr},
                                         {"bytes_per_s", report.bytes_per_s},
                                         {"rate_hz", report.rate_hz},
                                         {"sample_bytes", nullptr},
                                         {"samples", report.samples},
                                         {"lost", nullptr}});
  } else {
    output.line(
        output.fitted(fmt::format("{}: {}/s sent over the network, {}, {} so far", counts.topic(),
                                  bytes_text(report.bytes_per_s), rate_text(report.rate_hz), report.samples),
                      live_indent));
  }
  return report.samples;
}

ExitCode run_on_counts(PublisherCounts& counts, const BwOptions& options, bool json, Session& session) {
  std::uint64_t samples = 0;
  report_every_second(options.live, session.stop(),
                      [&] { samples = print_bytes(counts, json, session.output()); });
  return samples > 0 ? ExitCode::done : ExitCode::nothing;
}

}  // namespace

ExitCode run(const BwOptions& options, const CommonOptions& common, Session& session) {
  const Result<FoundTopic> topic = session.find(options.topic);
  if (!topic) {
    const auto counts = counts_instead(options.topic, topic.error(), session);
    return counts ? run_on_counts(*counts, options, common.json, session) : give_up(topic.error());
  }
  auto measured = Arrivals::open(*topic, sizes(options), session.node());
  if (!measured) return give_up(measured.error());
  Result<std::unique_ptr<Arrivals>> counted;
  if (!options.every) {
    counted = Arrivals::open(*topic, {.fields = "", .options = {.depth = 1024}}, session.node());
    if (!counted) return give_up(counted.error());
  }
  std::uint64_t samples = 0;
  report_every_second(options.live, session.stop(), [&] {
    const Arrivals::Report size = (*measured)->report(options.live.window_s);
    const Arrivals::Report rate = options.every ? size : (*counted)->report(options.live.window_s);
    samples = rate.samples;
    print(options, rate, size, common.json, topic->name, session.output());
  });
  return samples > 0 ? ExitCode::done : ExitCode::nothing;
}

}  // namespace sft::tool
