#include "bench/paper/session.h"

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <numeric>
#include <optional>
#include <random>

#include "bench/common/pair.h"
#include "bench/common/statistics.h"

namespace sft::bench::paper {

namespace {

constexpr double timeout_s = 40;
constexpr std::int64_t lead_ns = 300'000'000;  // the time from the start signal until the first message

/// Returns random slots of the contenders, since a contender may suffer from the work of the previous one
/// after its message.
std::vector<std::size_t> turns(std::size_t contenders, std::uint64_t seed) {
  std::vector<std::size_t> slots(contenders);
  std::iota(slots.begin(), slots.end(), std::size_t{0});
  std::shuffle(slots.begin(), slots.end(), std::mt19937_64(seed));
  return slots;
}

using Teams = std::vector<std::unique_ptr<Team>>;
/// The resources that each team has used up to a moment.
using Moment = std::vector<Used>;

Moment moment(const Teams& teams) {
  Moment all;
  for (const auto& team : teams) all.push_back(team->used());
  return all;
}

Moment moment_at(const Teams& teams, std::int64_t ns) {
  if (const std::int64_t left = ns - now_ns(); left > 0) sleep_us(left / 1000);
  return moment(teams);
}

/// Waits until all teams are ready. Ends and removes teams that are not ready in time.
void wait_until_ready(Teams& teams) {
  const auto ready = [](const auto& team) { return team->is_ready(); };
  if (wait_until([&] { return std::ranges::all_of(teams, ready); }, timeout_s)) return;
  std::erase_if(teams, [&](const auto& team) {
    if (ready(team)) return false;
    std::fprintf(stderr, "%s: not all nodes found each other%s\n", name_of(team->contender()).c_str(),
                 team->is_silent() ? " (idle twin)" : "");
    return true;
  });
}

struct Measured {
  Used phase;  ///< the resources used during the counted messages
  Used idle;   ///< the resources that the twin used in the same time
  double resident_bytes = 0;
};

std::size_t number_of(std::size_t sample, const Phase& phase, const Pace& pace) {
  return (pace.settling + sample) % phase.messages->size();
}

/// Returns the mean of a value over all messages that are counted.
template <class Size>
double mean_over(const Phase& phase, const Pace& pace, Size size) {
  double sum = 0;
  for (std::size_t i = 0; i < pace.samples; ++i) sum += static_cast<double>(size(number_of(i, phase, pace)));
  return sum / static_cast<double>(pace.samples);
}

Received received(const Phase& phase, std::size_t receiver, const Contender& contender, const Pace& pace) {
  const Messages& messages = *phase.messages;
  const bool selects = contender.way == Way::sft_recorded || contender.way == Way::sft_declared;
  const FieldSet fields = selects ? phase.needed[receiver] : messages.all();
  const auto bytes = [&](std::size_t number) { return messages.masked_bytes(number, fields); };
  return {.fields = fields,
          .cdr_bytes = mean_over(phase, pace, bytes),
          .least_bytes = mean_over(phase, pace, [&](std::size_t n) { return paper::least_bytes(bytes(n)); })};
}

/// Returns the times until arrival in microseconds. Counts the messages that did not arrive.
std::vector<double> times_us(const Board& board, std::size_t phase, const Pace& pace, Record& record) {
  std::vector<double> times;
  for (std::size_t r = 0; r < record.receivers.size(); ++r) {
    std::size_t lost = 0;
    for (std::size_t i = 0; i < pace.samples; ++i) {
      const std::int64_t at = board.received_ns[phase][r][i];
      if (at == 0) ++lost;
      if (at != 0) times.push_back(static_cast<double>(at - board.sent_ns[phase][i]) / 1000);
    }
    record.receivers[r].lost = static_cast<double>(lost) / static_cast<double>(pace.samples);
  }
  return times;
}

Record record_of(const Team& team, const Phase& phase, std::size_t phase_number, const Pace& pace,
                 const Measured& measured) {
  Record record{.of = phase.of, .contender = team.contender()};
  const auto samples = static_cast<double>(pace.samples);
  const auto of_a_message = [&](double bytes, double idle_bytes) { return (bytes - idle_bytes) / samples; };
  const auto& idle = measured.idle.receiver_bytes;
  for (std::size_t r = 0; r < phase.of.configuration.receivers; ++r) {
    record.receivers.push_back(received(phase, r, team.contender(), pace));
    record.receivers[r].bytes = of_a_message(measured.phase.receiver_bytes[r], idle[r]);
  }
  record.sender_bytes = of_a_message(measured.phase.sender_bytes, measured.idle.sender_bytes);
  record.cpu_us = 1e6 * measured.phase.cpu_s / samples;
  record.resident_bytes = measured.resident_bytes;
  std::vector<double> times = times_us(team.board(), phase_number, pace, record);
  if (!times.empty()) record.p50_us = quantile(times, 0.5);
  return record;
}

/// Returns the delay of each counted message of a phase relative to its planned time.
std::vector<double> late_us(const Board& board, std::size_t phase, const Pace& pace) {
  std::vector<double> late;
  for (std::size_t i = 0; i < pace.samples; ++i)
    late.push_back(static_cast<double>(board.sent_ns[phase][i] - board.due_ns[phase][i]) / 1000);
  return late;
}

/// Starts each twin just after the first of its contenders, so that their bursts of idle traffic coincide.
Teams start(const Stage& stage, const Team::Task& task, std::uint64_t seed) {
  const std::size_t contenders = stage.contenders().size();
  const std::vector<std::size_t> slots = turns(contenders, seed);
  Teams teams;
  std::size_t twins = 0;
  for (std::size_t i = 0; i < contenders; ++i) {
    const Contender& contender = stage.contenders()[i];
    teams.push_back(std::make_unique<Team>(contender, stage.network(i), task, slots[i]));
    if (twins == stage.idle_twins().size() || stage.idle_twins()[twins] != idle_twin(contender)) continue;
    const auto network = stage.network(contenders + twins);
    teams.push_back(std::make_unique<Team>(stage.idle_twins()[twins++], network, task, Team::silent));
  }
  return teams;
}

/// Returns the index of the twin's team; the number of teams if there is no such team.
std::size_t twin_of(const Team& team, const Teams& teams) {
  const Contender twin = idle_twin(team.contender());
  const auto found = std::ranges::find_if(
      teams, [&](const auto& one) { return one->is_silent() && one->contender() == twin; });
  return static_cast<std::size_t>(found - teams.begin());
}

/// The counts of all teams before and after the counted messages of each phase.
struct Counts {
  std::vector<Moment> before, after;
};

Counts count(const Teams& teams, std::size_t phases, const Schedule& schedule) {
  Counts counts;
  for (std::size_t p = 0; p < phases; ++p) {
    counts.before.push_back(moment_at(teams, schedule.before_ns(p)));
    counts.after.push_back(moment_at(teams, schedule.after_ns(p)));
  }
  return counts;
}

Results results_of(const Teams& teams, const Team::Task& task, const Counts& counts) {
  Results results;
  for (std::size_t t = 0; t < teams.size(); ++t) {
    const std::size_t twin = twin_of(*teams[t], teams);
    if (teams[t]->is_silent() || twin == teams.size()) continue;
    const double resident_bytes = teams[t]->resident_bytes();
    for (std::size_t p = 0; p < task.phases.size(); ++p) {
      const Moment &before = counts.before[p], &after = counts.after[p];
      const Measured measured{after[t] - before[t], after[twin] - before[twin], resident_bytes};
      Record record = record_of(*teams[t], task.phases[p], p, task.pace, measured);
      const std::vector<double> late = late_us(teams[t]->board(), p, task.pace);
      record.disturbed = 1000 * std::ranges::max(late) > static_cast<double>(Schedule::late_max_ns());
      results.late_us.insert(results.late_us.end(), late.begin(), late.end());
      results.records.push_back(std::move(record));
    }
  }
  return results;
}

Results try_session(const Stage& stage, const Team::Task& task, std::uint64_t seed) {
  Teams teams = start(stage, task, seed);
  wait_until_ready(teams);
  const std::int64_t begin_ns = now_ns() + lead_ns;
  for (const auto& team : teams) team->begin(begin_ns);
  const Counts counts = count(teams, task.phases.size(), Schedule(task.pace, task.slots, begin_ns));
  return results_of(teams, task, counts);
}

bool is_mostly_disturbed(const Results& results) {
  const auto disturbed = std::ranges::count_if(results.records, &Record::disturbed);
  return 2 * static_cast<std::size_t>(disturbed) > results.records.size();
}

}  // namespace

Stage::Stage(std::vector<Contender> contenders) : contenders_(std::move(contenders)) {
  for (const Contender& contender : contenders_) {
    const Contender twin = idle_twin(contender);
    if (std::ranges::find(idle_twins_, twin) == idle_twins_.end()) idle_twins_.push_back(twin);
  }
  for (std::size_t i = 0; i < contenders_.size() + idle_twins_.size(); ++i) {
    networks_.push_back(std::make_shared<hosts::EmulatedNetwork>(make_hosts(1 + receivers_max, Trains::cut)));
  }
}

void run_session(const Stage& stage, std::size_t receivers, const std::vector<Phase>& phases,
                 const Pace& pace, std::uint64_t seed, Results& results) {
  constexpr std::size_t repetitions_max = 6;  // the limit for the whole benchmark, which has to end in time
  const Team::Task task{receivers, phases, pace, stage.contenders().size()};
  Results session = try_session(stage, task, seed);
  if (is_mostly_disturbed(session) && results.repeated_sessions < repetitions_max) {
    ++results.repeated_sessions;
    std::fprintf(stderr, "  once more, since the machine was busy with something else\n");
    session = try_session(stage, task, seed);
  }
  std::ranges::move(session.records, std::back_inserter(results.records));
  results.late_us.insert(results.late_us.end(), session.late_us.begin(), session.late_us.end());
}

}  // namespace sft::bench::paper
