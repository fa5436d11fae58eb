#include "bench/paper/plots.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <system_error>

#include "bench/common/process.h"
#include "bench/paper/rows.h"

namespace sft::bench::paper {

namespace {

constexpr Way shown[] = {Way::fast_dds, Way::cyclone, Way::sft_full, Way::sft_recorded};

/// gnuplot takes a comma for the end of a name.
std::string heading() {
  std::string text = "case";
  for (const Way way : shown) {
    std::string name = name_of(way);
    std::erase(name, ',');
    text += "," + name + ",deviation";
  }
  return text + "\n";
}

/// One line: the mean and the deviation over the repeats of each contender, best effort and by unicast.
std::string line(const Records& all, const std::string& label, const Cases& cases, const Metric& metric) {
  std::string text = "\"" + label + "\"";
  for (const Way way : shown) {
    const Spread values = spread(records_of(all, {way}, cases), metric);
    text += fmt::format(",{:.3f},{:.3f}", values.mean, values.deviation);
  }
  return text + "\n";
}

/// "5 x 128 B, 3 receivers, 50 %" becomes "5 x 128, 50 %", since one picture has one number of receivers.
std::string short_label(const Configuration& c) {
  return fmt::format("{} x {}, {} %", c.fields, c.field_bytes, c.percent);
}

double kbit_s(const Record& record) { return record.received_bytes() * 8 * 10 / 1000; }
double p50(const Record& record) { return record.p50_us; }

void write_parametric(const std::string& file, const Records& all, std::size_t receivers,
                      const Metric& metric) {
  std::ofstream out(file);
  out << heading();
  for (const std::string& label : labels(all)) {
    const auto of_label = records_of(all, {Way::cyclone}, labelled(label));
    if (of_label.empty()) continue;
    const Configuration& c = of_label.front().of.configuration;
    if (c.fields != 0 && c.receivers == receivers) out << line(all, short_label(c), labelled(label), metric);
  }
}

void write_cases(const std::string& file, const Records& all, const Metric& metric) {
  std::ofstream out(file);
  out << heading();
  for (const auto& rows : {nav2_rows(), point_cloud_rows()}) {
    for (const Row& row : rows) out << line(all, row.title, row.cases, metric);
  }
}

void write_trace(const std::string& messages_file, const std::string& events_file, const Trace& trace) {
  std::ofstream messages(messages_file), events(events_file);
  messages << "ms,bytes\n";
  for (const Trace::Message& message : trace.messages)
    messages << fmt::format("{:.4f},{:.0f}\n", message.at_ms, message.cdr_bytes);
  events << "event,ms,height\n"
         << fmt::format("the recorded fields change,{:.4f},3200\n", trace.changed_ms)
         << fmt::format("the publisher has applied them: {:.0f} us later,{:.4f},2800\n", trace.response_us(),
                        trace.applied_ms);
}

}  // namespace

std::string Plots::open(const std::string& directory) {
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  directory_ = ::open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  return directory_ >= 0 ? "" : "cannot write to " + directory + ": " + std::strerror(errno);
}

std::string Plots::path(const char* file) const {
  return fmt::format("/proc/self/fd/{}/{}", directory_, file);
}

bool Plots::draw(const Records& all, const std::optional<Trace>& trace) const {
  write_parametric(path("bandwidth_1.csv"), all, 1, kbit_s);
  write_parametric(path("bandwidth_3.csv"), all, 3, kbit_s);
  write_parametric(path("latency_1.csv"), all, 1, p50);
  write_parametric(path("latency_3.csv"), all, 3, p50);
  write_cases(path("cases_bandwidth.csv"), all, kbit_s);
  write_cases(path("cases_latency.csv"), all, p50);
  write_trace(path("trace.csv"), path("trace_events.csv"), trace.value_or(Trace{}));
  return succeeds(start_process([this] {
    if (fchdir(directory_) != 0) return 1;
    execlp("gnuplot", "gnuplot", SFT_PAPER_PLOTS, nullptr);
    return 1;
  }));
}

}  // namespace sft::bench::paper
