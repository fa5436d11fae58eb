#include "tools/demo/figures.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "tools/terminal/columns.h"
#include "tools/terminal/units.h"

namespace sft::demo {

namespace {

using tool::aligned_bytes_text;
using tool::grouped_count_text;

// The smallest share of the bytes of whole messages that is reported
constexpr double worth_telling = 0.0005;
constexpr std::size_t request_columns = 24;
constexpr std::string_view row_format = "{:<9} {:<24} {:<3} {:>8} {:>4} {:>9} {:>9} {:>6}";

/// Returns the value with one decimal, because no figure is more exact; null if it was not measured.
nlohmann::ordered_json rounded(const std::optional<double>& value) {
  if (!value) return nullptr;
  return std::round(*value * 10) / 10;
}

double sum(const RunFigures& run, const auto& of) {
  double total = 0;
  for (const SubscriberFigures& s : run.subscribers) total += static_cast<double>(of(s));
  return total;
}

double bytes_between(const SubscriberFigures& s, const Counts& from) {
  return s.metered ? std::max(0.0, static_cast<double>(s.counts.wire_bytes - from.wire_bytes))
                   : static_cast<double>(s.counts.payload_bytes - from.payload_bytes);
}

std::string format_us(const std::optional<double>& latency_us) {
  if (!latency_us) return "-";
  const double us = std::max(0.0, *latency_us);
  return us < 99'999.5 ? grouped_count_text(static_cast<std::uint64_t>(std::llround(us)))
                       : fmt::format("{:.1f} s", us / 1e6);
}

/// Formats the share as a percentage, rounded down: "100 %" would mean that nothing crossed the network.
std::string format_percent(double share) { return tool::percent_text(share, 1, share > 0.999 ? 4 : 1); }

std::string row(const SubscriberFigures& s) {
  std::string sent = "-", saved = "-";
  if (s.in_shared_memory()) {
    sent = aligned_bytes_text(0);
    saved = "all";
  } else if (s.counts.samples > 0) {
    sent = aligned_bytes_text(s.bytes_per_sample().value_or(0)) + (s.metered ? "" : " *");
    saved = s.saved() > worth_telling ? format_percent(s.saved()) : "nothing";
  }
  return tool::shortened(fmt::format(row_format, s.name, tool::shortened(format_request(s), request_columns),
                                     s.transport, grouped_count_text(s.counts.samples),
                                     grouped_count_text(s.lost), sent, saved, format_us(s.p50_us)),
                         columns_max);
}

std::string format_result(const RunFigures& run) {
  if (run.samples == 0) return "Nothing was published.";
  const double carried = run.carried_bytes(), whole = run.whole_bytes();
  const double saved = whole > 0 ? 1 - carried / whole : 0;
  return fmt::format(
      "{} carried {}{}; {} lost.", run.real_hosts() ? "The network" : "UDP", aligned_bytes_text(carried),
      saved > worth_telling
          ? fmt::format(" instead of {}: {} saved", aligned_bytes_text(whole), format_percent(saved))
          : ": nothing saved",
      run.lost() == 0 ? "nothing" : grouped_count_text(run.lost()));
}

std::string format_comparison(const RunFigures& run) {
  const auto others =
      std::ranges::count_if(run.subscribers, [](const auto& s) { return !s.in_shared_memory(); });
  std::string text = fmt::format("{} would be every whole cloud for each of the {} subscribers {}.",
                                 aligned_bytes_text(run.whole_bytes()), others,
                                 run.real_hosts() ? "on other hosts" : "that are served by UDP");
  if (others < static_cast<std::ptrdiff_t>(run.subscribers.size()))
    text += " In shared memory nothing is copied or sent.";
  return text;
}

/// Returns a text about the cost of recording fields; empty if no fields were recorded.
std::string format_learning(const RunFigures& run) {
  if (std::ranges::none_of(run.subscribers, &SubscriberFigures::recorded)) return {};
  const double bytes = sum(run, [](const auto& s) { return s.learning_bytes().value_or(0); });
  return "Nobody declared fields: those above are what each was seen to read" +
         (bytes > 0 ? fmt::format(". Finding that out took {} of the bytes.", aligned_bytes_text(bytes))
                    : ".");
}

}  // namespace

double SubscriberFigures::bytes() const { return bytes_between(*this, begin); }

std::optional<double> SubscriberFigures::bytes_per_sample() const {
  const Counts& steady = learnt ? *learnt : begin;
  if (counts.samples <= steady.samples) return std::nullopt;
  return bytes_between(*this, steady) / static_cast<double>(counts.samples - steady.samples);
}

std::optional<double> SubscriberFigures::learning_bytes() const {
  if (!metered) return std::nullopt;
  const bool still_learns = recorded && !learnt && !in_shared_memory();
  const Counts& end = still_learns ? counts : learnt ? *learnt : begin;
  return static_cast<double>(end.wire_bytes - begin.wire_bytes);
}

double SubscriberFigures::saved() const {
  if (full_bytes == 0 || counts.samples == 0) return 0;
  const auto due = static_cast<double>(counts.samples + withheld);
  const double sent = bytes_per_sample().value_or(0) * static_cast<double>(counts.samples);
  return 1 - sent / due / static_cast<double>(full_bytes);
}

void SubscriberFigures::count_missing_as_lost(std::uint64_t published) {
  lost = std::max(lost, published - std::min(published, counts.samples + withheld));
}

std::uint64_t RunFigures::lost() const {
  return static_cast<std::uint64_t>(sum(*this, [](const auto& s) { return s.lost; }));
}

double RunFigures::carried_bytes() const {
  return sum(*this, [](const auto& s) { return s.in_shared_memory() ? 0 : s.bytes(); });
}

double RunFigures::whole_bytes() const {
  return sum(*this, [this](const auto& s) { return s.in_shared_memory() ? 0 : s.full_bytes * samples; });
}

nlohmann::ordered_json to_json(const RunFigures& run) {
  nlohmann::ordered_json subscribers = nlohmann::ordered_json::array();
  for (const SubscriberFigures& s : run.subscribers) {
    subscribers.push_back({
        {"name", s.name},
        {"transport", s.transport},
        {"reason", s.reason},
        {"fields", s.fields},
        {"requirement", s.recorded ? "recorded" : "declared"},
        {"received", s.counts.samples},
        {"lost", s.lost},
        {"withheld", s.withheld},
        {"full_bytes_per_sample", rounded(static_cast<double>(s.full_bytes))},
        {"wire_bytes_per_sample", rounded(s.metered ? s.bytes_per_sample() : std::nullopt)},
        {"learning_bytes", rounded(s.learning_bytes())},
        {"latency_us", {{"p50", rounded(s.p50_us)}, {"p99", rounded(s.p99_us)}}},
    });
  }
  return {
      {"samples", run.samples},
      {"hosts", run.hosts},
      {"carried_bytes", rounded(run.carried_bytes())},
      {"whole_bytes", rounded(run.whole_bytes())},
      {"subscribers", subscribers},
  };
}

std::string format_request(const SubscriberFigures& s) {
  const std::string text = s.asks_for_all     ? "all"
                           : s.fields.empty() ? "none"
                                              : fmt::format("{}", fmt::join(s.fields, ", "));
  return s.max_rate_hz > 0 ? fmt::format("{}, {:g} Hz", text, s.max_rate_hz) : text;
}

std::vector<std::string> format_table(const RunFigures& run) {
  std::vector<std::string> lines{
      fmt::format(row_format, "name", "asks for", "via", "received", "lost", "a cloud", "saved", "p50 us")};
  for (const SubscriberFigures& s : run.subscribers) lines.push_back(row(s));
  return lines;
}

std::string format_progress(const RunFigures& run, double elapsed_s) {
  return tool::shortened(
      fmt::format("{:5.1f} s: {} published; {} carried {}, not {}; {} lost", elapsed_s,
                  grouped_count_text(run.samples), run.real_hosts() ? "the network" : "UDP",
                  aligned_bytes_text(run.carried_bytes()), aligned_bytes_text(run.whole_bytes()),
                  grouped_count_text(run.lost())),
      columns_max);
}

std::vector<std::string> format_summary(const RunFigures& run) {
  const std::uint64_t full = run.subscribers.empty() ? 0 : run.subscribers.front().full_bytes;
  std::vector<std::string> lines{format_result(run), ""};
  for (const std::string& paragraph :
       {fmt::format("The lidar published {} clouds of a generated yard ({} each) at {:g} Hz.",
                    grouped_count_text(run.samples), aligned_bytes_text(static_cast<double>(full)), run.hz),
        format_comparison(run), format_learning(run),
        std::string("p50 is the median time from publish() to the subscriber's callback."),
        std::string(run.real_hosts()
                        ? "Bytes are as counted by each host's network interface, packet headers included, "
                          "without control traffic."
                        : "All of it ran on this machine, and what would go between hosts went over "
                          "loopback, where bytes on the wire cannot be counted for each subscriber: figures "
                          "marked * are payload. The first lines say why there are no real hosts.")}) {
    if (paragraph.empty()) continue;
    for (std::string& line : tool::lines_of(paragraph, columns_max, tool::LongWords::whole))
      lines.push_back(std::move(line));
  }
  return lines;
}

std::vector<std::string> format_refusals(const PublisherReport& publisher) {
  std::vector<std::string> lines;
  if (!publisher.udp.starts_with("io_uring"))
    lines.push_back("io_uring is not in use, so UDP is slower than it could be: " + publisher.udp + ".");
  if (!publisher.shm_ready)
    lines.push_back("Shared memory is not in use, so the detector is served by UDP: " + publisher.shm + ".");
  return lines;
}

}  // namespace sft::demo
