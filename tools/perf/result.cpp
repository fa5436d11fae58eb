#include "tools/perf/result.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>

#include "tools/terminal/units.h"

namespace sft::perf {

namespace {

using Json = nlohmann::ordered_json;

constexpr double percents[] = {50, 90, 99, 99.9, 99.99};

std::optional<double> in_seconds(std::optional<double> ns) {
  return ns ? std::optional(*ns * 1e-9) : std::nullopt;
}

Json json_of(std::optional<double> value) { return value ? Json(*value) : Json(nullptr); }

std::string text_of(std::optional<double> seconds) { return seconds ? tool::duration_text(*seconds) : "-"; }

Json json_of(const Histogram& times) {
  Json json{{"samples", times.count()},
            {"min", json_of(in_seconds(times.min()))},
            {"mean", json_of(in_seconds(times.mean()))}};
  for (const double percent : percents)
    json[fmt::format("p{:g}", percent)] = json_of(in_seconds(times.percentile(percent)));
  json["max"] = json_of(in_seconds(times.max()));
  return json;
}

Json json_of(const Usage& usage) {
  return {{"cpu_s", usage.cpu_s},
          {"context_switches", usage.switches},
          {"bytes_in", usage.bytes_in},
          {"bytes_out", usage.bytes_out},
          {"memory_bytes", usage.memory_bytes}};
}

Json json_of(const Lane& lane, const Outcome& run) {
  const bool one_way = run.answers && why_no_one_way(run).empty() && lane.there.count() > 0;
  return {{"name", lane.name},
          {"fields", lane.fields.empty() ? Json(nullptr) : Json(lane.fields)},
          {"path", lane.path},
          {"message_bytes", lane.message_bytes},
          {"sent", lane.sent},
          {"refused", lane.refused},
          {"late", lane.late},
          {"arrived", lane.arrived},
          {"returned", run.answers ? Json(lane.returned) : Json(nullptr)},
          {"lost_there", json_of(lane.values(run.answers).at("lost_there"))},
          {"lost_back", json_of(lane.values(run.answers).at("lost_back"))},
          {"reordered", lane.reordered},
          {"twice", lane.twice},
          {"seconds", lane.seconds},
          {"rate_hz", json_of(lane.values(run.answers).at("rate"))},
          {"latency_s", json_of(lane.latency)},
          {"there_s", one_way ? json_of(lane.there) : Json(nullptr)},
          {"back_s", one_way ? json_of(lane.back) : Json(nullptr)},
          {"jitter_s", json_of(lane.jitter_s())},
          {"first_s", json_of(lane.first_s)},
          {"here", json_of(lane.here)},
          {"far", json_of(lane.far)}};
}

std::string usage_text(const char* side, const Usage& usage, double seconds) {
  return fmt::format(
      "    {}: {} of a core, {} context switches, {} in and {} out at the interfaces, memory {}\n", side,
      tool::percent_text(usage.cpu_s, seconds, 1), usage.switches,
      tool::bytes_text(static_cast<double>(usage.bytes_in)),
      tool::bytes_text(static_cast<double>(usage.bytes_out)),
      tool::bytes_text(static_cast<double>(usage.memory_bytes)));
}

std::string text_of(const Lane& lane, const Outcome& run) {
  const Values values = lane.values(run.answers);
  std::string text =
      fmt::format("{}{}{}, {} of {} at {}{}{}{}\n", lane.name, lane.fields.empty() ? "" : " ", lane.fields,
                  tool::count_text(lane.sent, "sample"), tool::bytes_text(lane.message_bytes),
                  tool::rate_text(values.at("rate").value_or(0)),
                  lane.late > 0 ? fmt::format(", {} sent late", lane.late) : "",
                  lane.refused > 0 ? fmt::format(", {} refused", lane.refused) : "",
                  lane.path.empty() ? "" : ", by " + lane.path);
  if (run.answers) {
    const Histogram& times = lane.latency;
    text += "    half a round trip: min " + text_of(in_seconds(times.min()));
    for (const double percent : percents)
      text += fmt::format(", p{:g} {}", percent, text_of(in_seconds(times.percentile(percent))));
    text += fmt::format(", max {}; jitter {}, first {}\n", text_of(in_seconds(times.max())),
                        text_of(lane.jitter_s()), text_of(lane.first_s));
    if (why_no_one_way(run).empty() && lane.there.count() > 0)
      text += fmt::format(
          "    one way: there p50 {}, p99 {}; back p50 {}, p99 {}\n",
          text_of(in_seconds(lane.there.percentile(50))), text_of(in_seconds(lane.there.percentile(99))),
          text_of(in_seconds(lane.back.percentile(50))), text_of(in_seconds(lane.back.percentile(99))));
  } else {
    text += fmt::format("    arrived: {}, {} a second\n", tool::count_text(lane.arrived, "sample"),
                        tool::bytes_text(values.at("rate").value_or(0) * lane.message_bytes));
  }
  text += fmt::format("    lost: {} there", values.at("lost_there").value_or(0));
  if (run.answers)
    text += fmt::format(", {} back; {} reordered, {} twice", values.at("lost_back").value_or(0),
                        lane.reordered, lane.twice);
  return text + '\n' + usage_text("here", lane.here, lane.seconds) +
         usage_text("far", lane.far, lane.seconds);
}

/// The beginning of a picture, with the colours and dashes of the plots in docs/performance.md.
constexpr const char* svg_head =
    R"svg(<svg xmlns="http://www.w3.org/2000/svg" class="plot" viewBox="0 0 420 {height}">
<style>svg.plot {{ --ink: #1b1f24; --paper: #ffffff; --line: #d0d7de; --c0: #0969da; --c1: #bc4c00;
  --c2: #bf3989; --c3: #6e7781; color: var(--ink); background: var(--paper); }}
@media (prefers-color-scheme: dark) {{ svg.plot {{ --ink: #e6edf3; --paper: #0d1117; --line: #30363d;
  --c0: #58a6ff; --c1: #f0883e; --c2: #f778ba; --c3: #8b949e; }} }}
text {{ fill: currentColor; font: 11px system-ui, 'DejaVu Sans', sans-serif; }}
.grid {{ stroke: var(--line); }} .curve {{ fill: none; stroke-width: 2; }}</style>
<text x="8" y="16" font-weight="600">Samples that took longer, of {type}</text>
)svg";
constexpr const char* dashes[] = {"", "7 3", "2 3", "9 3 2 3"};

/// The axes of the picture. Times from `begin_ns` on are horizontal, with equal widths for decades. Shares
/// of all samples are vertical.
struct Axes {
  double begin_ns = 1000;
  double decades = 1;
  double x(double ns) const { return 60 + 340 * std::clamp(std::log10(ns / begin_ns) / decades, 0.0, 1.0); }
  static double y(double part) { return 34 - 40 * std::log10(std::clamp(part, 1e-5, 1.0)); }
};

std::string curve(const Lane& lane, std::size_t number, const Axes& axes) {
  std::string points;
  std::uint64_t below = 0;
  for (const Histogram::Class& each : lane.latency.classes()) {
    const double part = 1 - static_cast<double>(below) / static_cast<double>(lane.latency.count());
    below += each.count;
    points += fmt::format("{:.1f},{:.1f} ", axes.x(static_cast<double>(each.begin)), Axes::y(part));
  }
  return fmt::format(
             R"svg(<polyline class="curve" stroke="var(--c{})" stroke-dasharray="{}" points="{}"/>)svg",
             number % 4, dashes[number % 4], points) +
         '\n';
}

}  // namespace

std::optional<double> Lane::jitter_s() const {
  return jitter_count == 0 ? std::nullopt : std::optional(jitter_sum_s / static_cast<double>(jitter_count));
}

Values Lane::values(bool answers) const {
  const auto gap = [](std::uint64_t of, std::uint64_t came) {
    return static_cast<double>(of - std::min(of, came));
  };
  Values values{
      {"min", in_seconds(latency.min())},
      {"mean", in_seconds(latency.mean())},
      {"max", in_seconds(latency.max())},
      {"jitter", jitter_s()},
      {"first", first_s},
      {"sent", static_cast<double>(sent)},
      {"late", static_cast<double>(late)},
      {"reordered", static_cast<double>(reordered)},
      {"twice", static_cast<double>(twice)},
      {"lost_there", gap(sent, arrived)},
      {"lost_back", answers ? std::optional(gap(arrived, returned)) : std::nullopt},
      {"lost", gap(sent, answers ? returned : arrived)},
      {"rate", seconds > 0 ? std::optional(static_cast<double>(answers ? returned : arrived) / seconds)
                           : std::nullopt}};
  for (const double percent : percents)
    values[fmt::format("p{:g}", percent)] = in_seconds(latency.percentile(percent));
  return values;
}

std::string why_no_one_way(const Outcome& run) {
  if (!run.clocks_within_s) return run.clocks;
  if (run.offset_s &&
      (run.any_negative || std::abs(*run.offset_s) > run.offset_error_s + *run.clocks_within_s))
    return fmt::format("clocks disagree by {}", tool::duration_text(*run.offset_s));
  return "";
}

Json json_of(const Outcome& run, const std::vector<std::string>& failed) {
  Json lanes = Json::array();
  for (const Lane& lane : run.lanes) lanes.push_back(json_of(lane, run));
  const std::string no_one_way = why_no_one_way(run);
  return {{"type", run.type},
          {"reliability", run.reliability},
          {"sides", run.sides},
          {"rate_asked_hz", run.rate_hz},
          {"interrupted", run.interrupted},
          {"error", run.error.empty() ? Json(nullptr) : Json(run.error)},
          {"lanes", std::move(lanes)},
          {"clock",
           {{"latency", "CLOCK_MONOTONIC of this host"},
            {"hosts", run.clocks},
            {"within_s", json_of(run.clocks_within_s)},
            {"offset_s", json_of(run.offset_s)},
            {"offset_error_s", run.offset_error_s},
            {"no_one_way", no_one_way.empty() ? Json(nullptr) : Json(no_one_way)}}},
          {"remarks", run.remarks},
          {"failed", failed}};
}

std::string text_of(const Outcome& run) {
  std::string text =
      fmt::format("{}, {}, {}\n", run.type, run.reliability, tool::count_text(run.sides, "other side"));
  for (const Lane& lane : run.lanes) text += text_of(lane, run);
  const std::string no_one_way = why_no_one_way(run);
  text += no_one_way.empty() ? "clocks: " + run.clocks + '\n' : "no one-way times: " + no_one_way + '\n';
  for (const std::string& remark : run.remarks) text += remark + '\n';
  if (run.interrupted) text += "interrupted: these are the figures so far\n";
  return text;
}

std::string svg_of(const Outcome& run) {
  Axes axes;
  double least = 1e9, most = 1e3;
  for (const Lane& lane : run.lanes) {
    least = std::min(least, lane.latency.min().value_or(least));
    most = std::max(most, lane.latency.max().value_or(most));
  }
  axes.begin_ns = std::pow(10, std::floor(std::log10(std::max(least, 1.0))));
  axes.decades = std::max(1.0, std::ceil(std::log10(most / axes.begin_ns)));
  const auto height = 270 + 16 * run.lanes.size();
  std::string svg =
      fmt::format(fmt::runtime(svg_head), fmt::arg("height", height), fmt::arg("type", run.type));
  for (int i = 0; i <= 5; ++i)
    svg += fmt::format(
        "<line class=\"grid\" x1=\"60\" x2=\"400\" y1=\"{0}\" y2=\"{0}\"/><text x=\"54\" y=\"{1}\" "
        "text-anchor=\"end\">{2:g} %</text>\n",
        34 + 40 * i, 38 + 40 * i, 100 * std::pow(10, -i));
  for (int i = 0; i <= static_cast<int>(axes.decades); ++i)
    svg += fmt::format(
        "<line class=\"grid\" x1=\"{0:.1f}\" x2=\"{0:.1f}\" y1=\"34\" y2=\"234\"/><text x=\"{0:.1f}\" "
        "y=\"248\" text-anchor=\"middle\">{1:g} us</text>\n",
        60 + 340 * i / axes.decades, axes.begin_ns * std::pow(10, i) / 1e3);
  for (std::size_t i = 0; i < run.lanes.size(); ++i) {
    const Lane& lane = run.lanes[i];
    const auto y = 266 + 16 * i;
    svg += curve(lane, i, axes) +
           fmt::format(
               "<line class=\"curve\" stroke=\"var(--c{0})\" stroke-dasharray=\"{1}\" x1=\"60\" x2=\"90\" "
               "y1=\"{2}\" y2=\"{2}\"/><text x=\"98\" y=\"{3}\">{4}, {5}</text>\n",
               i % 4, dashes[i % 4], y - 4, y, lane.name, tool::bytes_text(lane.message_bytes));
  }
  return svg + "</svg>\n";
}

}  // namespace sft::perf
