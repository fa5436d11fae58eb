#include "bench/isolation/results.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

namespace sft::bench::isolation {

namespace {

constexpr const char* without = "without the remote reader";

/// Formats a time in ms and its ratio to the baseline, as "1.23 (1.02)"; "none" if there is no time.
std::string beside(double us, double baseline_us) {
  if (std::isnan(us)) return "none";
  if (std::isnan(baseline_us)) return fmt::format("{:.2f}", us / 1000);
  return fmt::format("{:.2f} ({:.2f})", us / 1000, us / baseline_us);
}

std::string times(const Times& here, const Times& baseline) {
  return fmt::format("{:>13} {:>13} {:>13}", beside(here.p50, baseline.p50), beside(here.p99, baseline.p99),
                     beside(here.worst, baseline.worst));
}

std::string line(const std::string& phase, const Summary& here, const Summary& baseline) {
  return fmt::format("  {:<8} {} | {} | {:>5.1f} {:>8.0f} {:>10.0f} {:>6} {:>4} {:>9}\n", phase,
                     times(here.local, baseline.local), times(here.publish, baseline.publish),
                     here.published_hz, here.cpu_percent, here.remote_cpu_percent, here.page_faults,
                     here.lost, here.remote_received);
}

std::string suffix(Middleware middleware) {
  if (middleware == Middleware::sft) return "";
  return middleware == Middleware::cyclone ? "_cyclone" : "_fast_dds";
}

Figure p99(const std::string& name, const Times& here, const Times& baseline) {
  return {.name = name,
          .value = here.p99,
          .unit = "us",
          .reference = baseline.p99,
          .reference_name = without,
          .worst = here.p99_of_worst_round};
}

std::vector<Figure> figures_of(const Results& results, const Contender& contender, Phase phase,
                               const std::string& prefix) {
  const Summary here = results.of(contender, phase), baseline = results.baseline(contender);
  const std::string end = suffix(contender.middleware);
  std::vector<Figure> figures{p99(prefix + "_local_p99" + end, here.local, baseline.local),
                              p99(prefix + "_publish_p99" + end, here.publish, baseline.publish)};
  if (contender.middleware != Middleware::sft) return figures;
  figures[0].bound = local_ratio_max;
  figures.push_back({.name = prefix + "_lost", .value = static_cast<double>(here.lost)});
  figures.push_back({.name = prefix + "_cpu",
                     .value = here.cpu_percent,
                     .unit = "%",
                     .reference = baseline.cpu_percent,
                     .reference_name = without});
  return figures;
}

/// Returns the ratio of the second part of the baseline to its first part. It differs from 1 only because
/// of noise.
Figure noise(const Results& results, const Contender& contender, const std::string& prefix) {
  Figure figure = p99(prefix + "_again_local_p99" + suffix(contender.middleware),
                      results.of(contender, Phase::again).local, results.of(contender, Phase::alone).local);
  figure.reference_name = "the same before: noise";
  return figure;
}

}  // namespace

void Results::add(const Contender& contender, Phase phase, Observation observation) {
  observations_[contender][phase].push_back(std::move(observation));
}

bool Results::has(const Contender& contender) const { return observations_.contains(contender); }

Summary Results::of(const Contender& contender, Phase phase) const {
  return summarize(observations_.at(contender).at(phase));
}

Summary Results::baseline(const Contender& contender) const {
  const auto& phases = observations_.at(contender);
  std::vector<Observation> rounds = phases.at(Phase::alone);
  const std::vector<Observation>& others = phases.at(Phase::again);
  rounds.insert(rounds.end(), others.begin(), others.end());
  return summarize(rounds);
}

std::vector<double> Results::late_us() const {
  std::vector<double> late;
  for (const auto& [contender, phases] : observations_) {
    for (const auto& [phase, rounds] : phases) {
      for (const Observation& round : rounds)
        late.insert(late.end(), round.late_us.begin(), round.late_us.end());
    }
  }
  return late;
}

std::string legend() {
  return std::string(R"(
local       from before publish() until a reader on the same host has the message, in ms
publish()   its duration, in ms
(1.02)      the ratio to the baseline, which is all time )") +
         without + R"(
p50, p99    medians over the rounds; worst is of all rounds
Hz          messages that were published in a second
host CPU    of the publisher and the local readers, in % of one processor; remote CPU: of the remote reader
faults      page faults in publish(): memory that its process uses for the first time
lost        messages that a local reader did not get, summed over the readers
to remote   messages of the phase that the remote reader got, also later

alone, again: there is no remote reader, so that the two differ by noise only. Then a remote reader of all
fields joins, stalls (SIGSTOP), loses 20 % of its packets, has a link of 50 Mbit/s, and is killed.
)";
}

std::string table(const Results& results, const Contender& contender) {
  const Summary baseline = results.baseline(contender);
  std::string text =
      fmt::format("\n{}\n  {:<8} {:>13} {:>13} {:>13} | {:>13} {:>13} {:>13} | {:>5} {} {} {} {} {}\n",
                  name_of(contender), "phase", "local p50", "p99", "worst", "publish() p50", "p99", "worst",
                  "Hz", "host CPU", "remote CPU", "faults", "lost", "to remote");
  text += line("baseline", baseline, baseline);
  for (const Phase phase : all_phases) text += line(name_of(phase), results.of(contender, phase), baseline);
  return text;
}

std::vector<Figure> figures(const Results& results, bool reliable) {
  const std::string prefix = reliable ? "isolation" : "isolation_best_effort";
  std::vector<Figure> all;
  const auto add = [&](std::vector<Figure> more) {
    all.insert(all.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
  };
  for (const Middleware middleware : all_middleware) {
    const Contender contender{middleware, reliable};
    if (results.has(contender)) add({noise(results, contender, prefix)});
  }
  for (const Phase phase : disturbances) {
    for (const Middleware middleware : all_middleware) {
      const Contender contender{middleware, reliable};
      if (results.has(contender)) add(figures_of(results, contender, phase, prefix + "_" + name_of(phase)));
    }
  }
  return all;
}

}  // namespace sft::bench::isolation
