#include "bench/paper/csv.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <ostream>

namespace sft::bench::paper {

namespace {

/// The values of all receivers, with spaces in between.
template <class Value>
std::string of_all(const Record& record, Value value) {
  std::string text;
  for (const Received& receiver : record.receivers) {
    if (!text.empty()) text += ' ';
    text += fmt::format("{:.1f}", static_cast<double>(value(receiver)));
  }
  return text;
}

std::string fields_of_all(const Record& record) {
  std::string text;
  for (const Received& receiver : record.receivers)
    text += fmt::format("{}{}", text.empty() ? "" : " ", receiver.fields);
  return text;
}

double lost(const Record& record) {
  return std::accumulate(record.receivers.begin(), record.receivers.end(), 0.,
                         [](double most, const Received& one) { return std::max(most, one.lost); });
}

std::string line(const Record& record) {
  const Configuration& c = record.of.configuration;
  const std::string of = fmt::format("{},{},{},{},{},{}", record.of.name, c.fields, c.field_bytes,
                                     c.receivers, c.percent, record.of.repeat + 1);
  const std::string who =
      fmt::format("\"{}\",{},{},{}", name_of(record.contender.way), record.contender.reliable ? 1 : 0,
                  record.contender.multicast ? 1 : 0, fields_of_all(record));
  const std::string bytes = fmt::format(
      "{},{},{},{:.1f},{:.1f},{:.1f},{:.1f}", of_all(record, [](const Received& r) { return r.cdr_bytes; }),
      of_all(record, [](const Received& r) { return r.least_bytes; }),
      of_all(record, [](const Received& r) { return r.bytes; }), record.received_bytes(), record.sender_bytes,
      record.idle_receiver_bytes_per_s, record.idle_bytes_per_s);
  return fmt::format("{},{},{},{:.1f},{:.1f},{:.4f},{:.1f},{:.0f}\n", of, who, bytes, record.p50_us,
                     record.p99_us, lost(record), record.cpu_us, record.resident_bytes);
}

}  // namespace

void write_csv(std::ostream& out, const Records& all) {
  out << "case,fields,field_bytes,receivers,probability_percent,repeat,contender,reliable,multicast,"
         "masks_of_receivers,cdr_bytes_of_receivers,least_bytes_of_receivers,bytes_of_receivers,received_"
         "bytes,"
         "sender_bytes,idle_receivers_bytes_per_s,idle_sender_bytes_per_s,p50_us,p99_us,lost_share,cpu_us,"
         "resident_bytes\n";
  for (const Record& record : all) out << line(record);
  out << std::flush;  // an isolated program ends without destroying the stream
}

}  // namespace sft::bench::paper
