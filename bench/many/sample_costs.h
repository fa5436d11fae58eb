// Measures what a sample costs that a publisher sends many readers: bytes that leave the publisher's host,
// processor time, and latency. The bytes of the same nodes without samples are taken off; the processor time
// is all that they took.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <limits>
#include <vector>

#include "bench/common/host_processes.h"
#include "bench/common/shared.h"
#include "bench/common/signal.h"
#include "bench/many/members.h"

namespace sft::bench {

struct Case {
  std::size_t readers;
  std::size_t hosts;
  Topic topic;                 ///< with messages
  std::vector<Fields> phases;  ///< what the same readers ask for, one after the other
  double settling_s;  ///< for which samples are sent until the bytes settle; 0: it does not wait for that
  std::uint64_t samples;
  std::int64_t period_us;
  std::int64_t settled_us =
      1'000'000;              ///< a time in which discovery sends next to nothing is a sign of its end
  std::uint64_t warming = 0;  ///< samples that do not count
};

/// The costs of a sample.
struct Costs {
  static constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

  double bytes = unknown;
  double publisher_cpu_us = unknown;
  double subscriber_cpu_us = unknown;
  double latency_us = unknown;  ///< the median of all samples at all readers
  double settled_ms = unknown;
};

/// One case with one contender. It begins at once, and goes on until wait().
class SampleCosts {
 public:
  SampleCosts(const Member& member, const Case& of);

  /// The costs of each phase.
  std::vector<Costs> wait();

  // For the processes of the crowd.

  static constexpr std::size_t readers_max = 64, phases_max = 4, arrivals_max = 16'384;

  struct Board {
    std::atomic<std::size_t> knowing{0};       ///< readers' nodes that know the publisher
    std::array<Signal, readers_max> go;        ///< a reader begins the next phase
    std::atomic<std::size_t> matched{0};       ///< readers, in all phases together
    std::atomic<std::int64_t> sent_ns{0};      ///< when the last sample was sent
    std::atomic<std::uint64_t> received{0};    ///< samples that all readers together have received
    std::array<double, arrivals_max> us = {};  ///< that each of them took, in a ring
    std::array<pid_t, readers_max> readers = {};
    std::array<Costs, phases_max> costs;

    void note_arrival() {
      const std::int64_t ns = now_ns() - sent_ns;
      us[received++ % arrivals_max] = static_cast<double>(ns) / 1000;
    }
  };

 private:
  const Member member_;
  const std::size_t phases_;
  const Shared<Board> board_;
  HostProcesses processes_;
};

}  // namespace sft::bench
