#include "bench/peers/tables.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "bench/peers/pace.h"

namespace sft::bench::peers {

namespace {

constexpr std::size_t samples_of_p999 = 1000;  // with fewer, it is the worst one

using Cell = std::function<std::string(const Records&)>;

/// The entrants of all columns that have records.
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

struct Rival {
  Entrant entrant;
  Spread spread;
};

/// Peers whose median is better than that of SFT, the best first. "about" marks those whose range overlaps.
std::vector<std::string> better(const Records& all, const Column& column, const Spread& ours,
                                double Record::*value, bool more_is_better) {
  const double sign = more_is_better ? -1 : 1;
  std::vector<Rival> rivals;
  for (const Entrant& entrant : entrants(column.of)) {
    const Spread theirs = spread(records_of(all, column.of, entrant, column.bytes), value);
    if (entrant.is_sft() || entrant.way == Way::memcpy_alone) continue;
    if (sign * theirs.median < sign * ours.median) rivals.push_back({entrant, theirs});
  }
  std::ranges::sort(rivals, {}, [=](const Rival& rival) { return sign * rival.spread.median; });
  std::vector<std::string> texts;
  for (const Rival& rival : rivals) {
    const bool overlaps = rival.spread.least <= ours.most && ours.least <= rival.spread.most;
    const double scale = more_is_better ? 1000 : 1;
    texts.push_back(fmt::format("{} {}{}", name_of(rival.entrant), overlaps ? "about " : "",
                                number_text(rival.spread.median / scale)));
  }
  return texts;
}

std::string faster_line(const Records& all, const Column& column, const Entrant& entrant,
                        double Record::*value, bool more_is_better, const char* unit) {
  const Spread ours = spread(records_of(all, column.of, entrant, column.bytes), value);
  if (!std::isfinite(ours.median)) return "";
  const std::vector<std::string> rivals = better(all, column, ours, value, more_is_better);
  return fmt::format("    {:<24} {:<16} {:>9} {:<4} {}\n", column.label, name_of(entrant),
                     number_text(ours.median / (more_is_better ? 1000 : 1)), unit,
                     rivals.empty() ? "no peer is faster" : fmt::format("{}", fmt::join(rivals, "; ")));
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

std::string faster_peers(const Records& all, const std::vector<Column>& columns) {
  std::string text =
      "\n  Which peers are faster than SFT in latency (p50; \"about\": the ranges of the rounds overlap)\n";
  for (const Column& column : columns) {
    for (const Way way : {Way::sft_full, Way::sft_loan})
      text += faster_line(all, column, {way}, &Record::p50_us, false, "us");
  }
  text += "  Which peers are faster than SFT in throughput\n";
  for (const Column& column : columns) {
    for (const Way way : {Way::sft_full, Way::sft_loan})
      text += faster_line(all, column, {way}, &Record::per_s, true, "k/s");
  }
  return text;
}

}  // namespace sft::bench::peers
