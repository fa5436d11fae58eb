#include "tools/demo/screen/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/terminal/columns.h"
#include "tools/terminal/units.h"

namespace sft::demo {

namespace {

using tool::aligned_bytes_text;
using tool::grouped_count_text;

constexpr double worth_telling = 0.0005;  // as a share of the bytes of whole clouds
constexpr std::size_t request_columns = 24;
constexpr std::size_t input_columns = 50;
constexpr std::string_view row_format = "{:<9} {:<24} {:<3} {:>8} {:>4} {:>9} {:>9} {:>6}";

/// Rounds down, since 100 % would mean that nothing crossed the network.
std::string format_percent(double share) {
  const int decimals = share > 0.999 ? 4 : 1;
  const double digits = std::pow(10, decimals);
  return fmt::format("{:.{}f} %", std::floor(share * 100 * digits) / digits, decimals);
}

std::string row(const RunFigures& run, const SubscriberFigures& s) {
  std::string sent = "-", saved = "-", latency = "-";
  if (s.counts.received != 0) {
    sent = aligned_bytes_text(s.sent_bytes()) + (run.real_hosts() || s.in_shared_memory() ? "" : " *");
    const double share = s.saved(run.whole_bytes);
    saved = s.in_shared_memory() ? "all" : share > worth_telling ? format_percent(share) : "nothing";
    const double us = std::max(0.0, s.counts.latency_p50_us);
    latency = us < 99'999.5 ? grouped_count_text(static_cast<std::uint64_t>(std::llround(us)))
                            : fmt::format("{:.1f} s", us / 1e6);
  }
  return tool::shortened(
      fmt::format(row_format, s.name, tool::shortened(format_request(s.route), request_columns),
                  s.in_shared_memory() ? "shm" : "udp", grouped_count_text(s.counts.received),
                  grouped_count_text(s.counts.lost), sent, saved, latency),
      columns_max);
}

std::string format_result(const RunFigures& run) {
  if (run.samples == 0) return "Nothing was published.";
  const Carried carried = run.carried();
  std::string text = fmt::format("{} carried {}", run.real_hosts() ? "The network" : "UDP",
                                 aligned_bytes_text(carried.bytes));
  text += carried.saved() > worth_telling
              ? fmt::format(" instead of {}: {} saved", aligned_bytes_text(carried.whole_bytes),
                            format_percent(carried.saved()))
              : ": nothing saved";
  return text +
         (run.lost() == 0 ? "; nothing lost." : fmt::format("; {} lost.", grouped_count_text(run.lost())));
}

std::string format_source(const RunFigures& run) {
  return fmt::format("The lidar published {} clouds ({}, {} on average) at {:g} Hz from: {}.",
                     grouped_count_text(run.samples), run.message_shape, aligned_bytes_text(run.whole_bytes),
                     run.hz, tool::shortened(run.input, input_columns));
}

std::string format_comparison(const RunFigures& run) {
  const auto others =
      std::ranges::count_if(run.subscribers, [](const auto& s) { return !s.in_shared_memory(); });
  std::string text = fmt::format("{} would be every whole cloud for each of the {} subscribers {}.",
                                 aligned_bytes_text(run.carried().whole_bytes), others,
                                 run.real_hosts() ? "on other hosts" : "that are served by UDP");
  if (others < std::ssize(run.subscribers)) text += " In shared memory nothing is copied or sent.";
  return text;
}

/// Empty unless fields were recorded.
std::string format_learning(const RunFigures& run) {
  if (!run.recorded) return {};
  std::int64_t bytes = 0;
  for (const SubscriberFigures& s : run.subscribers) bytes += s.counts.learning_bytes;
  return fmt::format(
      "No fields were declared: those above are what each was seen to read. Finding that out "
      "took {} of the bytes.",
      aligned_bytes_text(static_cast<double>(bytes)));
}

std::string format_measurement(const RunFigures& run) {
  if (!run.real_hosts()) {
    return "All of it ran on this machine, and what would go between hosts went over loopback, where bytes "
           "on the wire cannot be told apart by subscriber: figures marked * are payload. The first lines "
           "say why there are no real hosts.";
  }
  return "Bytes are as counted by each host's network interface, packet headers included, without control "
         "traffic (who is there, and who needs what).";
}

}  // namespace

std::string format_request(const Route& route) {
  std::string text = route.all_fields ? "all" : route.fields.str();
  return route.max_rate_hz > 0 ? fmt::format("{}, {:g} Hz", text, route.max_rate_hz) : text;
}

std::vector<std::string> format_table(const RunFigures& run) {
  std::vector<std::string> lines{
      fmt::format(row_format, "who", "asks for", "by", "received", "lost", "a cloud", "saved", "p50 us")};
  for (const SubscriberFigures& s : run.subscribers) lines.push_back(row(run, s));
  return lines;
}

std::string format_progress(const RunFigures& run, double elapsed_s) {
  const Carried carried = run.carried();
  return tool::shortened(
      fmt::format("{:5.1f} s: {} published; {} carried {}, not {}; {} lost", elapsed_s,
                  grouped_count_text(run.samples), run.real_hosts() ? "the network" : "UDP",
                  aligned_bytes_text(carried.bytes), aligned_bytes_text(carried.whole_bytes),
                  grouped_count_text(run.lost())),
      columns_max);
}

std::vector<std::string> format_summary(const RunFigures& run) {
  std::vector<std::string> lines{format_result(run), ""};
  for (const std::string& paragraph :
       {format_source(run), format_comparison(run), format_learning(run),
        std::string(run.lost() == 0 ? "" : "Clouds were lost: was the machine too busy?"),
        std::string("p50 is the median time from publish() to the subscriber's callback."),
        format_measurement(run)}) {
    if (paragraph.empty()) continue;
    for (std::string& line : tool::lines_of(paragraph, columns_max, tool::LongWords::whole))
      lines.push_back(std::move(line));
  }
  return lines;
}

}  // namespace sft::demo
