// Counts the work for a sample that is sent while all threads sleep, and the work of idle nodes. Counts do
// not depend on the speed of the machine. They include the sleep of the program until its next sample,
// which costs the sender one system call and one wake-up.
#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "bench/common/counters.h"
#include "bench/udp/paced_pair.h"
#include "bench/udp/udp.h"

namespace sft::bench {

namespace {

constexpr std::int64_t idle_us = 3'000'000;

struct Rate {
  const char* name;
  Paced paced;

  /// Returns the divisor of the counts. They are per sample or, without samples, per second.
  double divisor() const {
    return paced.messages > 0 ? static_cast<double>(paced.messages) : static_cast<double>(idle_us) / 1e6;
  }
  const char* unit() const { return paced.messages > 0 ? "a sample" : "a second"; }
};

struct PairCounts {
  std::vector<ThreadCounts> sender, receiver;
};

std::optional<PairCounts> count(Contender contender, const Rate& rate, const TwoHosts& hosts) {
  std::optional<ProcessCounter> sender, receiver;
  PairCounts counts;
  bool complete = false;
  const bool passed = pass_paced(
      contender, rate.paced, hosts,
      [&](const PacedPair& pair) {
        sender.emplace(pair.sender);
        receiver.emplace(pair.receiver);
      },
      [&](const PacedPair&) {
        counts = {sender->read(), receiver->read()};
        complete = sender->same_threads() && receiver->same_threads();
      });
  if (!passed) return std::nullopt;
  if (!complete) fmt::print("    Threads came or went, and were not counted.\n");
  return counts;
}

std::string number(const std::optional<std::int64_t>& count, double divisor) {
  return count ? fmt::format("{:.2f}", static_cast<double>(*count) / divisor) : "-";
}

void print_row(const char* side, const std::string& thread, const Counts& counts, double divisor) {
  const auto per = [&](auto count) { return static_cast<double>(count) / divisor; };
  std::string calls;
  for (const auto& [name, times] : counts.calls) {
    if (per(times) >= 0.005) calls += fmt::format(" {} {:.2f}", name, per(times));
  }
  fmt::print("    {:<10} {:<16} {:>9} {:>9.2f} {:>9.2f} {:>8.1f} {}\n", side, thread,
             number(counts.system_calls, divisor), per(counts.wake_ups), per(counts.preemptions),
             per(counts.cpu_ns) / 1000, calls);
}

void print_side(const char* side, const std::vector<ThreadCounts>& threads, double divisor) {
  for (const ThreadCounts& thread : threads) {
    const Counts& counts = thread.counts;
    if (counts.wake_ups > 0 || counts.system_calls.value_or(0) > 0)
      print_row(side, thread.name, counts, divisor);
  }
  print_row(side, "all", sum_of(threads), divisor);
}

void print(const char* contender, const Rate& rate, const PairCounts& counts) {
  fmt::print("{}, {}, {}:\n", contender, rate.name, rate.unit());
  fmt::print("    {:<10} {:<16} {:>9} {:>9} {:>9} {:>8}  {}\n", "side", "thread", "sys calls", "wake-ups",
             "preempted", "CPU us", "system calls by name");
  print_side("publisher", counts.sender, rate.divisor());
  print_side("subscriber", counts.receiver, rate.divisor());
  std::fflush(stdout);  // otherwise each process that is forked later would have a copy of these lines
}

/// A count of one kind on one side, as a column of the table.
struct Column {
  std::string name;
  std::optional<std::int64_t> (*count)(const Counts&);
  std::optional<double> ours{}, cyclone{};
};

class Contest {
 public:
  explicit Contest(const Rate& rate) : rate_(rate) {
    for (const char* side : {"publisher", "subscriber"}) {
      const std::string name = std::string("cold_") + rate.name + "_" + side;
      columns_.push_back({name + "_calls", [](const Counts& c) { return c.system_calls; }});
      columns_.push_back({name + "_wake_ups", [](const Counts& c) { return std::optional(c.wake_ups); }});
    }
  }

  void run(const TwoHosts& hosts) {
    add(count(sft_peer, rate_, hosts), "SFT", &Column::ours);
    add(count(cyclone_peer, rate_, hosts), "Cyclone DDS", &Column::cyclone);
    if (rate_.paced.messages == 0) return;  // without samples, sockets do nothing
    if (const auto raw = count(raw_udp_peer, rate_, hosts)) print("raw UDP", rate_, *raw);
  }
  /// Adds figures, except for counts that are not available on the machine.
  void figures(std::vector<Figure>& to) const {
    const char* unit = rate_.paced.messages > 0 ? "" : "/s";
    for (const Column& column : columns_) {
      if (column.ours) to.push_back({column.name, *column.ours, unit, column.cyclone, "Cyclone DDS"});
    }
  }

 private:
  void add(const std::optional<PairCounts>& counts, const char* contender,
           std::optional<double> Column::*to) {
    if (!counts) return fmt::print("{}, {}: a sample was lost\n", contender, rate_.name);
    print(contender, rate_, *counts);
    const std::array sums{sum_of(counts->sender), sum_of(counts->receiver)};
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      if (const auto counted = columns_[i].count(sums[2 * i / columns_.size()]))
        columns_[i].*to = static_cast<double>(*counted) / rate_.divisor();
    }
  }

  const Rate rate_;
  std::vector<Column> columns_;
};

}  // namespace

/// One round is enough, since counts hardly differ between rounds.
std::vector<Figure> cold_path(const Scale&) {
  const TwoHosts hosts(Trains::whole);
  const Topic small{.reliable = false};
  std::array contests{Contest({"idle", {small, 0, idle_us}}), Contest({"10Hz", {small, 30, 100'000}}),
                      Contest({"100Hz", {small, 200, 10'000}}), Contest({"1kHz", {small, 1000, 1000}})};
  const ProcessCounter own(getpid());
  for (const std::string& what : own.uncountable()) fmt::print("not counted: {}\n", what);
  std::fflush(stdout);
  std::vector<Figure> figures;
  for (Contest& contest : contests) {
    contest.run(hosts);
    contest.figures(figures);
  }
  return figures;
}

}  // namespace sft::bench
