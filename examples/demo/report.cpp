#include "examples/demo/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace sft::demo {

namespace {

const std::string latency_note =
    "Latency is from publish() to the subscriber's callback: half of the samples took p50 at most, 99 % "
    "p99.\n";
constexpr double worth_telling = 0.0005;  // of a message saved

constexpr std::string_view row_format = "{:<10} {:<7} {:<3} {:<14} {:>12} {:>9} {:>7} {:>8} {:>8} {:>4}  {}";

std::string format_us(const std::optional<double>& latency_us) {
  return latency_us ? format_count(static_cast<std::uint64_t>(std::llround(std::max(0.0, *latency_us))))
                    : "-";
}

/// Never rounded up to 100 %: something did cross the network.
std::string format_percent(double share) {
  const double percent = share * 100;
  const double digits = percent > 99.9 ? 1e4 : 10;
  return fmt::format("{:.{}f} %", std::floor(percent * digits) / digits, percent > 99.9 ? 4 : 1);
}

std::string format_saved(const SubscriberFigures& s) {
  const std::optional<double> saved = s.saved();
  if (s.in_shared_memory()) return "all";
  if (!saved) return "-";
  return *saved > worth_telling ? format_percent(*saved) : "nothing";
}

std::string format_wire(const RunFigures& run, const SubscriberFigures& s) {
  if (s.wire_bytes_per_sample) return format_bytes(*s.wire_bytes_per_sample);
  if (!run.real_hosts() && !s.in_shared_memory()) return format_bytes(s.payload_bytes_per_sample) + " *";
  return "-";
}

std::string row(const RunFigures& run, const SubscriberFigures& s) {
  return fmt::format(row_format, s.name, s.host, s.transport, format_fields(s), format_wire(run, s),
                     format_saved(s), format_us(s.latency_p50_us), format_us(s.latency_p99_us),
                     format_count(s.received), format_count(s.lost), s.reason);
}

double full_bytes(const RunFigures& run) {
  return run.subscribers.empty() ? 0 : run.subscribers.front().full_bytes_per_sample;
}

/// Who it is and what it needs, and on a line of its own what that took.
std::string explain(const RunFigures& run, const SubscriberFigures& s) {
  const std::string where = s.in_shared_memory() ? "the publisher's host"
                            : run.real_hosts()   ? "host " + s.host
                                                 : "this machine";
  std::string text = fmt::format("  {:<10} on {} {} {}\n{:13}", s.name, where,
                                 s.recorded ? "was seen to read" : "declared", format_fields(s), "");
  if (s.received == 0) return text + "nothing arrived\n";
  if (s.in_shared_memory()) {
    return text +
           "all readers of a host share one sample in shared memory: nothing copied for it, nothing sent\n";
  }
  if (!s.wire_bytes_per_sample) {
    return text + fmt::format("{} a sample arrived *\n", format_bytes(s.payload_bytes_per_sample));
  }
  text += fmt::format("{} a sample crossed the network", format_bytes(*s.wire_bytes_per_sample));
  text += *s.saved() > worth_telling ? fmt::format(" instead of {}: {} saved",
                                                   format_bytes(s.full_bytes_per_sample), format_saved(s))
                                     : ", nearly the whole message and the headers of its packets";
  if (s.recorded && s.learning_bytes) {
    text += fmt::format(", after {} to learn that", format_bytes(*s.learning_bytes));
  }
  return text + "\n";
}

/// All remote subscribers together, against every one of them being sent everything.
std::string explain_total(const RunFigures& run) {
  double sent = 0;
  double full = 0;
  for (const SubscriberFigures& s : run.subscribers) {
    if (s.in_shared_memory() || !s.wire_bytes_per_sample) continue;
    sent += *s.wire_bytes_per_sample;
    full += s.full_bytes_per_sample;
  }
  if (full == 0) return {};
  std::string text =
      fmt::format("Together: {} a sample over the network; whole messages for everybody would be {}",
                  format_bytes(sent), format_bytes(full));
  return text + (sent < full ? fmt::format(", so {} saved.\n", format_percent(1 - sent / full)) : ".\n");
}

std::string explain_lost(const RunFigures& run) {
  std::string text;
  for (const SubscriberFigures& s : run.subscribers) {
    if (s.lost == 0) continue;
    text += fmt::format("{}{} lost {} of {}", text.empty() ? "" : ", ", s.name, format_count(s.lost),
                        format_count(run.samples));
    if (s.incomplete != 0) text += fmt::format(" ({} came in part)", format_count(s.incomplete));
  }
  if (text.empty()) return "Nothing was lost.\n";
  if (run.dropped != 0) {
    text += fmt::format("; {} found a full queue at the publisher", format_count(run.dropped));
  }
  return fmt::format("Lost: {}. Was the machine too busy?\n", text);
}

std::string explain_measurement(const RunFigures& run) {
  if (!run.real_hosts()) {
    return latency_note +
           "All of it ran on this machine, with the network path forced over loopback, where bytes on the "
           "wire cannot be\n"
           "told apart by subscriber: figures marked * are payload. Run as root for real hosts and their "
           "networks.\n";
  }
  std::string text = latency_note;
  text +=
      "Bytes are as counted by each host's network interface, packet headers included, without control "
      "traffic.\n";
  if (run.idle_bytes_per_s) {
    text += fmt::format(
        "Control traffic (who is there, and who needs what) is {:.0f} bytes/s per node, idle or not.\n",
        *run.idle_bytes_per_s);
  }
  return text;
}

}  // namespace

std::vector<std::string> format_table(const RunFigures& run) {
  std::vector<std::string> lines{fmt::format(row_format, "subscriber", "host", "by", "fields", "bytes/sample",
                                             "saved", "p50 us", "p99 us", "received", "lost", "because")};
  for (const SubscriberFigures& s : run.subscribers) lines.push_back(row(run, s));
  return lines;
}

std::string format_progress(const RunFigures& run, double elapsed_s) {
  std::string received;
  std::uint64_t lost = 0;
  for (const SubscriberFigures& s : run.subscribers) {
    received += fmt::format("{}{} {}", received.empty() ? "" : ", ", s.name, format_count(s.received));
    lost += s.lost;
  }
  return fmt::format("{:5.1f} s: {} published; received by {}; {} lost", elapsed_s, format_count(run.samples),
                     received, lost);
}

std::vector<std::string> format_refusals(const PublisherReport& publisher) {
  std::vector<std::string> lines;
  if (!publisher.udp.starts_with("io_uring"))
    lines.push_back("io_uring is not in use, so UDP is slower than it could be: " + publisher.udp + ".");
  if (!publisher.shm_ready)
    lines.push_back("Shared memory is not in use, so the viewer is served by UDP: " + publisher.shm + ".");
  return lines;
}

std::string format_summary(const RunFigures& run) {
  std::string text = fmt::format(
      "The lidar published {} point clouds ({}, {} on average) at {:g} Hz from: {}.\n",
      format_count(run.samples), run.message_shape, format_bytes(full_bytes(run)), run.hz, run.input);
  for (const SubscriberFigures& s : run.subscribers) text += explain(run, s);
  return text + explain_total(run) + explain_lost(run) + explain_measurement(run);
}

}  // namespace sft::demo
