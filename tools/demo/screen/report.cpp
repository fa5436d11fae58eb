#include "tools/demo/screen/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/terminal/columns.h"
#include "tools/terminal/units.h"

namespace sft::demo {

namespace {

constexpr double worth_telling = 0.0005;  // as a share of the bytes of whole messages
constexpr std::size_t request_columns = 24;

constexpr std::string_view row_format = "{:<9} {:<24} {:<3} {:>8} {:>4} {:>9} {:>9} {:>6}";

std::string format_us(const std::optional<double>& latency_us) {
  if (!latency_us) return "-";
  const double us = std::max(0.0, *latency_us);
  return us < 99'999.5 ? tool::grouped_count_text(static_cast<std::uint64_t>(std::llround(us)))
                       : fmt::format("{:.1f} s", us / 1e6);
}

/// Rounds down, since 100 % would mean that nothing crossed the network.
std::string format_percent(double share) {
  const double percent = share * 100;
  const double digits = percent > 99.9 ? 1e4 : 10;
  return fmt::format("{:.{}f} %", std::floor(percent * digits) / digits, percent > 99.9 ? 4 : 1);
}

std::string format_saved(const SubscriberFigures& s) {
  if (s.in_shared_memory()) return "all";
  if (s.received == 0) return "-";
  return s.saved() > worth_telling ? format_percent(s.saved()) : "nothing";
}

std::string format_sent(const SubscriberFigures& s) {
  if (s.in_shared_memory()) return tool::aligned_bytes_text(0);
  if (s.received == 0) return "-";
  return tool::aligned_bytes_text(s.sent_bytes_per_sample()) + (s.wire_bytes_per_sample ? "" : " *");
}

std::string row(const SubscriberFigures& s) {
  return tool::shortened(
      fmt::format(row_format, s.name, tool::shortened(format_request(s), request_columns), s.transport,
                  tool::grouped_count_text(s.received), tool::grouped_count_text(s.lost), format_sent(s),
                  format_saved(s), format_us(s.latency_p50_us)),
      columns_max);
}

/// Returns the path of the samples of remote subscribers.
std::string_view way_of(const RunFigures& run) { return run.real_hosts() ? "the network" : "UDP"; }

std::string format_result(const RunFigures& run) {
  if (run.samples == 0) return "Nothing was published.";
  const Carried carried = run.carried();
  std::string text = fmt::format("{} carried {}", run.real_hosts() ? "The network" : "UDP",
                                 tool::aligned_bytes_text(carried.bytes));
  text += carried.saved() > worth_telling
              ? fmt::format(" instead of {}: {} saved", tool::aligned_bytes_text(carried.whole_bytes),
                            format_percent(carried.saved()))
              : ": nothing saved";
  return text + (run.lost() == 0 ? "; nothing lost."
                                 : fmt::format("; {} lost.", tool::grouped_count_text(run.lost())));
}

std::string format_source(const RunFigures& run) {
  const double full = run.subscribers.empty() ? 0 : run.subscribers.front().full_bytes_per_sample;
  return fmt::format("The lidar published {} clouds of a generated yard ({} each) at {:g} Hz.",
                     tool::grouped_count_text(run.samples), tool::aligned_bytes_text(full), run.hz);
}

std::string format_comparison(const RunFigures& run) {
  const auto others = std::count_if(run.subscribers.begin(), run.subscribers.end(),
                                    [](const SubscriberFigures& s) { return !s.in_shared_memory(); });
  std::string text = fmt::format("{} would be every whole cloud for each of the {} subscribers {}.",
                                 tool::aligned_bytes_text(run.carried().whole_bytes), others,
                                 run.real_hosts() ? "on other hosts" : "that are served by UDP");
  if (others < static_cast<std::ptrdiff_t>(run.subscribers.size()))
    text += " In shared memory nothing is copied or sent.";
  return text;
}

/// Returns an empty text unless fields were recorded.
std::string format_learning(const RunFigures& run) {
  double bytes = 0;
  bool recorded = false;
  for (const SubscriberFigures& s : run.subscribers) {
    recorded = recorded || s.recorded;
    bytes += s.learning_bytes.value_or(0);
  }
  if (!recorded) return {};
  const std::string text = "Nobody declared fields: those above are what each was seen to read";
  return bytes > 0 ? fmt::format("{}. Finding that out took {} of the bytes.", text,
                                 tool::aligned_bytes_text(bytes))
                   : text + ".";
}

std::string format_losses(const RunFigures& run) {
  std::string text;
  for (const SubscriberFigures& s : run.subscribers) {
    if (s.lost == 0) continue;
    text += fmt::format("{}{} lost {} of {}", text.empty() ? "" : ", ", s.name,
                        tool::grouped_count_text(s.lost), tool::grouped_count_text(run.samples));
    if (s.incomplete != 0) text += fmt::format(" ({} came in part)", tool::grouped_count_text(s.incomplete));
  }
  if (text.empty()) return {};
  if (run.dropped != 0)
    text += fmt::format("; {} found a full queue at the publisher", tool::grouped_count_text(run.dropped));
  return fmt::format("Lost: {}. Was the machine too busy?", text);
}

std::string format_measurement(const RunFigures& run) {
  if (!run.real_hosts()) {
    return "All of it ran on this machine, and what would go between hosts went over loopback, where bytes "
           "on the wire cannot be told apart by subscriber: figures marked * are payload. The first lines "
           "say why there are no real hosts.";
  }
  return "Bytes are as counted by each host's network interface, packet headers included, without control "
         "traffic.";
}

}  // namespace

std::vector<std::string> format_table(const RunFigures& run) {
  std::vector<std::string> lines{
      fmt::format(row_format, "who", "asks for", "by", "received", "lost", "a cloud", "saved", "p50 us")};
  for (const SubscriberFigures& s : run.subscribers) lines.push_back(row(s));
  return lines;
}

std::string format_progress(const RunFigures& run, double elapsed_s) {
  const Carried carried = run.carried();
  return tool::shortened(
      fmt::format("{:5.1f} s: {} published; {} carried {}, not {}; {} lost", elapsed_s,
                  tool::grouped_count_text(run.samples), way_of(run), tool::aligned_bytes_text(carried.bytes),
                  tool::aligned_bytes_text(carried.whole_bytes), tool::grouped_count_text(run.lost())),
      columns_max);
}

std::vector<std::string> format_refusals(const PublisherReport& publisher) {
  std::vector<std::string> lines;
  if (!publisher.udp.starts_with("io_uring"))
    lines.push_back("io_uring is not in use, so UDP is slower than it could be: " + publisher.udp + ".");
  if (!publisher.shm_ready)
    lines.push_back("Shared memory is not in use, so the detector is served by UDP: " + publisher.shm + ".");
  return lines;
}

std::vector<std::string> format_summary(const RunFigures& run) {
  std::vector<std::string> lines{format_result(run), ""};
  for (const std::string& paragraph :
       {format_source(run), format_comparison(run), format_learning(run), format_losses(run),
        std::string("p50 is the median time from publish() to the subscriber's callback."),
        format_measurement(run)}) {
    if (paragraph.empty()) continue;
    for (std::string& line : tool::lines_of(paragraph, columns_max, tool::LongWords::whole))
      lines.push_back(std::move(line));
  }
  return lines;
}

}  // namespace sft::demo
