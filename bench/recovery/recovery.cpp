#include "bench/recovery/recovery.h"

#include <algorithm>
#include <cstdio>
#include <limits>
#include <memory>
#include <optional>

#include "bench/common/statistics.h"
#include "tests/hostile/stage.h"

namespace sft::bench {

namespace {

using hostile::Entry;
using hostile::Moment;
using hostile::Stage;
using Times = std::vector<double>;

constexpr double worst_ms_max = 1000;
/// The limit after forgeries. Messages that were forged in the names of other processes lose their effect
/// when a link is made anew (SECURITY.md).
constexpr double worst_ms_max_after_forgeries = 5000;
constexpr double never = std::numeric_limits<double>::quiet_NaN();

/// Honest programs, which keep running from act to act. They are replaced only if one of them ends.
class Lives {
 public:
  explicit Lives(unsigned long seed) : seed_(seed) {}

  /// Returns the time in milliseconds until all pairs are served again and, if required, `sftd status`
  /// answers. Returns NaN if that does not happen.
  double recovery(const Entry& entry, Moment moment, std::chrono::milliseconds length) {
    if (moment != Moment::after_they_started) stage_.reset();
    const hostile::Outcome outcome = stage().perform(entry, moment, length);
    for (const std::string& complaint : outcome.complaints)
      std::fprintf(stderr, "%s: %s\n", std::string(entry.name).c_str(), complaint.c_str());
    const bool recovered = outcome.recovery && outcome.complaints.empty();
    // Files of another account that remain keep the programs from shared memory in later acts.
    if (!recovered || entry.harm == hostile::Harm::leaves_files) stage_.reset();
    if (!recovered) return never;
    return static_cast<double>(
        std::max(*outcome.recovery, outcome.command_line.value_or(hostile::Ms{})).count());
  }

  double restart() {
    if (!stage().start()) return never;
    const auto time = stage_->restart_publisher();
    return time ? static_cast<double>(time->count()) : never;
  }

 private:
  Stage& stage() {
    if (!stage_) stage_ = std::make_unique<Stage>(seed_++);
    return *stage_;
  }

  unsigned long seed_;
  std::unique_ptr<Stage> stage_;
};

/// Returns the longest time. Returns NaN, which counts as the worst result, if a round did not recover.
double worst_of(const Times& times) {
  const bool all_ended = std::ranges::none_of(times, [](double time) { return time != time; });
  return all_ended ? *std::ranges::max_element(times) : never;
}

double middle_of(Times times) {
  std::erase_if(times, [](double time) { return time != time; });
  return times.empty() ? never : quantile(times, 0.5);
}

void report(std::vector<Figure>& figures, const Entry& entry, const Times& times, const Times& floor) {
  const std::string name = "recovery_ms_" + std::string(entry.name);
  const double most = entry.harm == hostile::Harm::forges ? worst_ms_max_after_forgeries : worst_ms_max;
  const char* reference = "publisher killed and started";
  figures.push_back({name + "_p50", middle_of(times), "ms", middle_of(floor), reference, {}});
  figures.push_back({name + "_worst", worst_of(times), "ms", worst_of(floor), reference, most, true});
}

bool is_wanted(const Entry& entry, const RecoveryScale& scale) {
  return scale.act.empty() || entry.name == scale.act;
}

}  // namespace

std::vector<Figure> recovery_after_each_act(const RecoveryScale& scale) {
  if (const std::string refusal = Stage::refusal(); !refusal.empty()) {
    std::fprintf(stderr, "bench recovery: %s\n", refusal.c_str());
    return {{"recovery_ms", never, "ms", {}, {}, worst_ms_max}};
  }
  Lives lives(scale.seed);
  Times floor;
  for (int round = 0; round < scale.rounds; ++round) floor.push_back(lives.restart());
  std::vector<Figure> figures;
  for (const Entry& entry : hostile::acts()) {
    if (!is_wanted(entry, scale)) continue;
    Times times;
    for (int round = 0; round < scale.rounds; ++round)
      times.push_back(
          lives.recovery(entry, hostile::moments[static_cast<std::size_t>(round) % 3], scale.length));
    report(figures, entry, times, floor);
  }
  return figures;
}

}  // namespace sft::bench
