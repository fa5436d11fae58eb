// Records the times during which a CPU did not run threads that were ready to run.
#pragma once

#include <sched.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <stop_token>
#include <thread>
#include <vector>

#include "tests/support/pace.h"

namespace sft::test {

/// Some machines share their CPUs with other machines. A CPU of such a machine may do nothing for 100 ms, and
/// a time that is measured across such a standstill says nothing about the program. This monitor has one
/// thread on each of the first CPUs. The thread wakes every millisecond and records when it was late.
class StandstillMonitor {
 public:
  using Clock = std::chrono::system_clock;

  explicit StandstillMonitor(int cpus) : late_(static_cast<std::size_t>(cpus)) {
    for (int cpu = 0; cpu < cpus; ++cpu)
      threads_.emplace_back([cpu, &late = late_[static_cast<std::size_t>(cpu)]](const std::stop_token& stop) {
        cpu_set_t only;
        CPU_ZERO(&only);
        CPU_SET(cpu, &only);
        ::sched_setaffinity(0, sizeof only, &only);  // fails harmlessly if there are fewer CPUs
        for (Pace pace(period); !stop.stop_requested();) {
          const auto due = Clock::now() + period;
          pace.await_turn();
          if (const auto now = Clock::now(); now - due > least) late.push_back({due, now});
        }
      });
  }

  struct Standstill {
    Clock::time_point from, until;
  };
  /// Ends the threads. Returns the time spans in which at least one of the CPUs stood still. The spans are in
  /// order and do not overlap.
  std::vector<Standstill> end() {
    threads_.clear();
    std::vector<Standstill> all;
    for (const auto& of_cpu : late_) all.insert(all.end(), of_cpu.begin(), of_cpu.end());
    std::ranges::sort(all, {}, &Standstill::from);
    std::vector<Standstill> joined;
    for (const Standstill& next : all) {
      if (joined.empty() || joined.back().until < next.from)
        joined.push_back(next);
      else
        joined.back().until = std::max(joined.back().until, next.until);
    }
    return joined;
  }

  /// Returns the part of the time from `from` to `until` that is within the given spans.
  static Clock::duration within(const std::vector<Standstill>& spans, Clock::time_point from,
                                Clock::time_point until) {
    Clock::duration all{};
    for (const Standstill& span : spans)
      all += std::max(Clock::duration{}, std::min(until, span.until) - std::max(from, span.from));
    return all;
  }

 private:
  static constexpr std::chrono::milliseconds period{1}, least{30};

  // One list for each CPU, which only the thread on that CPU writes.
  std::vector<std::vector<Standstill>> late_;
  std::vector<std::jthread> threads_;
};

}  // namespace sft::test
