#include "bench/peers/tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "bench/peers/pace.h"

namespace sft::bench::peers {

namespace {

constexpr std::size_t samples_of_p999 = 1000;  // with fewer samples, the p999 equals the worst one

using Cell = std::function<std::string(const Records&)>;

/// Returns the entrants that have records in any of the columns.
std::vector<Entrant> rows_of(const Records& all, const std::vector<Column>& columns) {
  std::vector<Entrant> rows;
  for (const Column& column : columns) {
    for (const Entrant& entrant : entrants(column.of)) {
      if (std::ranges::find(rows, entrant) == rows.end() &&
          !records_of(all, column.of, entrant, column.bytes).empty())
        rows.push_back(entrant);
    }
  }
  return rows;
}

std::string spread_text(const Spread& spread) {
  if (!std::isfinite(spread.median)) return "-";
  if (spread.least == spread.most) return number_text(spread.median);
  return fmt::format("{} ({} to {})", number_text(spread.median), number_text(spread.least),
                     number_text(spread.most));
}

std::string tails_text(const Records& records) {
  const auto text = [&](double Record::*value) { return number_text(spread(records, value).median); };
  const bool few = std::ranges::any_of(records, [](const Record& r) { return r.samples < samples_of_p999; });
  return fmt::format("{} / {} / {}{}", text(&Record::p90_us), text(&Record::p99_us), text(&Record::p999_us),
                     few ? "w" : "");
}

std::string rate_text(const Records& records) {
  Records thousands = records;
  for (Record& record : thousands) record.per_s /= 1000;
  const Spread rate = spread(thousands, &Record::per_s);
  const double lost = spread(records, &Record::lost).most;
  return lost > 0 ? fmt::format("{}, lost {:.1f} %", number_text(rate.median), 100 * lost)
                  : spread_text(rate);
}

std::string table(const Records& all, const std::string& title, const std::vector<Column>& columns,
                  const Cell& cell) {
  std::string text = fmt::format("  {:<28}", title);
  for (const Column& column : columns) text += fmt::format(" {:>24}", column.label);
  for (const Entrant& entrant : rows_of(all, columns)) {
    text += fmt::format("\n    {:<26}", name_of(entrant));
    for (const Column& column : columns) {
      const Records records = records_of(all, column.of, entrant, column.bytes);
      text += fmt::format(" {:>24}", records.empty() ? "-" : cell(records));
    }
  }
  return text + "\n";
}

}  // namespace

std::vector<Column> columns_of_sizes(const Case& of, const std::vector<std::uint32_t>& sizes) {
  std::vector<Column> columns;
  for (const std::uint32_t bytes : sizes) columns.push_back({size_text(bytes), of, bytes});
  return columns;
}

std::vector<Column> columns_of_readers(Case of, const std::vector<std::size_t>& readers,
                                       std::uint32_t bytes) {
  std::vector<Column> columns;
  for (const std::size_t count : readers) {
    of.readers = count;
    const char* plural = count == 1 ? "" : "s";
    columns.push_back({fmt::format("{}, {} reader{}", size_text(bytes), count, plural), of, bytes});
  }
  return columns;
}

std::string number_text(double value) {
  if (!std::isfinite(value)) return "-";
  const double rounded = std::round(value);
  if (rounded >= 1000) {
    const auto whole = static_cast<std::uint64_t>(rounded);
    if (whole < 1'000'000) return fmt::format("{},{:03}", whole / 1000, whole % 1000);
    return fmt::format("{},{:03},{:03}", whole / 1'000'000, whole / 1000 % 1000, whole % 1000);
  }
  return fmt::format("{:.{}f}", value, value >= 99.95 ? 0 : value >= 9.995 ? 1 : 2);
}

std::string tables(const Records& all, const std::string& title, const std::vector<Column>& columns) {
  const auto of = [](double Record::*value) {
    return [value](const Records& records) { return spread_text(spread(records, value)); };
  };
  return fmt::format("\n{}\n", title) + table(all, "latency p50, us", columns, of(&Record::p50_us)) +
         table(all, "latency p90 / p99 / p99.9, us", columns, tails_text) +
         table(all, "CPU time of the same, us", columns, of(&Record::paced_cpu_us)) +
         table(all, "throughput, 1000 messages/s", columns, rate_text) +
         table(all, "CPU time of the same, us", columns, of(&Record::fast_cpu_us));
}

}  // namespace sft::bench::peers
