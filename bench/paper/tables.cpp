#include "bench/paper/tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>

namespace sft::bench::paper {

namespace {

double kbit_s(double bytes_of_a_message) { return bytes_of_a_message * 8 * 10 / 1000; }

std::string percent(double ratio) { return fmt::format("{:+.1f} %", 100 * (ratio - 1)); }

bool has_records(const Records& all, const Row& row) {
  return std::ranges::any_of(all, [&](const Record& record) { return row.cases(record.of); });
}

/// Formats a number of the paper; returns an empty text if the paper does not have it.
std::string published(const Row& row, double Published::*figure) {
  return row.published ? fmt::format("{:.1f}", (*row.published).*figure) : "";
}

/// Formats the rate of a contender in kbit/s and its difference from that of Cyclone DDS in the same cases:
/// "416.7 (-21.4 %)".
std::string beside_cyclone(const Records& all, const Row& row, const Metric& metric, Way way) {
  const double cyclone = means(all, {way}, {Way::cyclone}, row.cases, received_bytes).theirs;
  const double ours = means(all, {way}, {Way::cyclone}, row.cases, metric).ours;
  return fmt::format("{:.1f} ({})", kbit_s(ours), percent(ours / cyclone));
}

std::string bandwidth_line(const Records& all, const Row& row) {
  const auto bytes = [&](Way way) { return mean(records_of(all, {way}, row.cases), received_bytes); };
  const auto least = [](const Record& record) { return record.least_bytes(); };
  const std::string saving = row.saving ? percent(1 - *row.saving) : "";
  return fmt::format("{:<32} {:>9} {:>9} {:>9} {:>9} | {:>9.1f} {:>9.1f} {:>18} {:>18} {:>18} {:>18}\n",
                     row.title, published(row, &Published::fast_dds_kbit_s),
                     published(row, &Published::embedded_rtps_kbit_s), published(row, &Published::sft_kbit_s),
                     saving, kbit_s(bytes(Way::fast_dds)), kbit_s(bytes(Way::cyclone)),
                     beside_cyclone(all, row, received_bytes, Way::sft_recorded),
                     beside_cyclone(all, row, received_bytes, Way::sft_declared),
                     beside_cyclone(all, row, received_bytes, Way::sft_full),
                     beside_cyclone(all, row, least, Way::sft_recorded));
}

std::string latency_line(const Records& all, const Row& row) {
  const auto ms = [&](Way way) { return p50_us(records_of(all, {way}, row.cases)) / 1000; };
  const auto theirs = [&](double Published::*figure) {
    return row.published ? fmt::format("{:.2f}", (*row.published).*figure) : "";
  };
  return fmt::format("{:<32} {:>9} {:>9} {:>9} {:>9} | {:>9.3f} {:>9.3f} {:>18.3f} {:>18.3f} {:>18.3f}\n",
                     row.title, theirs(&Published::fast_dds_ms), theirs(&Published::embedded_rtps_ms),
                     theirs(&Published::sft_ms), "", ms(Way::fast_dds), ms(Way::cyclone),
                     ms(Way::sft_recorded), ms(Way::sft_declared), ms(Way::sft_full));
}

}  // namespace

std::string paper_table(const Records& all, const std::vector<Row>& rows) {
  const std::string columns =
      fmt::format("{:<32} {:>9} {:>9} {:>9} {:>9} | {:>9} {:>9} {:>18} {:>18} {:>18} {:>18}\n", "",
                  "Fast DDS", "Emb.RTPS", "SFT", "", "Fast DDS", "Cyclone", "SFT, recorded", "SFT, declared",
                  "SFT, all fields", "fewest possible");
  std::string text =
      "\nBest effort, unicast. Left: the paper. Right: this run.\n" + columns +
      "Mean bandwidth at the receivers, kbit/s at 10 Hz, and SFT beside the full message\n"
      "(fewest possible: the fields that receivers drew, and the headers of Ethernet, IP and UDP)\n";
  for (const Row& row : rows) {
    if (has_records(all, row)) text += bandwidth_line(all, row);
  }
  text += "Latency from publish() to the callback, ms; the paper has means, this run medians\n";
  for (const Row& row : rows) {
    if (has_records(all, row)) text += latency_line(all, row);
  }
  return text;
}

std::string draws_text(const Records& all) {
  std::string text = "\nFields that receivers drew:";
  for (const Row& row : parametric_rows()) {
    double fields = 0, drawn = 0, empty = 0;
    for (const Record& record : records_of(all, {Way::sft_recorded}, row.cases)) {
      for (const Received& receiver : record.receivers) {
        fields += static_cast<double>(record.of.configuration.fields);
        drawn += std::popcount(receiver.fields);
        empty += receiver.fields == 0 ? 1 : 0;
      }
    }
    text += fmt::format(" {}: {:.1f} %, {:.0f} without any;", row.title, 100 * drawn / fields, empty);
  }
  text.back() = '\n';
  return text;
}

}  // namespace sft::bench::paper
