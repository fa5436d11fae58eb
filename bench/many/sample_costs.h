// Measures the costs of a sample to many readers: bytes that leave the publisher's host, processor time,
// and latency. The bytes that the same nodes send without samples are subtracted. The processor time
// without samples is not subtracted.
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
  Topic topic;  ///< the topic of the samples, which has messages
  Fields fields;
  double settling_s;  ///< the time for the bytes to settle while samples are sent
  std::uint64_t samples;
  std::int64_t period_us;
};

/// The costs of a sample.
struct Costs {
  static constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

  double bytes = unknown;
  double publisher_cpu_us = unknown;
  double subscriber_cpu_us = unknown;
  double latency_us = unknown;  ///< the median over all samples and readers
  double settled_ms = unknown;
};

/// One case with one contender. It starts in the constructor, and ends in wait().
class SampleCosts {
 public:
  SampleCosts(const Member& member, const Case& of);

  /// Waits for the end of the case, and returns its costs.
  Costs wait();

  // The following members are for the processes of the case.

  static constexpr std::size_t readers_max = 64, arrivals_max = 16'384;

  struct Board {
    std::atomic<std::size_t> knowing{0};     ///< number of readers' nodes that know the publisher
    std::array<Signal, readers_max> go;      ///< signals that tell each reader to begin
    std::atomic<std::size_t> matched{0};     ///< number of matched readers
    std::atomic<std::int64_t> sent_ns{0};    ///< time when the last sample was sent
    std::atomic<std::uint64_t> received{0};  ///< number of received samples, summed over all readers
    /// The latency of each received sample in microseconds, in a ring.
    std::array<double, arrivals_max> us = {};
    std::array<pid_t, readers_max> readers = {};
    Costs costs;

    void note_arrival() {
      const std::int64_t ns = now_ns() - sent_ns;
      us[received++ % arrivals_max] = static_cast<double>(ns) / 1000;
    }
  };

 private:
  const Member member_;
  const Shared<Board> board_;
  HostProcesses processes_;
};

}  // namespace sft::bench
