// The memory that the processes of a trial share: the notes of the readers, and the results.
#pragma once

#include <sys/types.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <limits>

#include "bench/common/pair.h"
#include "bench/peers/pace.h"
#include "bench/peers/record.h"

namespace sft::bench::peers {

/// The messages of one size, numbered from 1, that a reader has received.
struct Receipts {
  alignas(64) std::atomic<std::uint64_t> last{0};  ///< the greatest number of a received message
  std::atomic<std::uint64_t> count{0};
  /// Time of arrival of each message; its index is the number of the message modulo samples_max.
  std::int64_t at_ns[samples_max] = {};

  void note(std::uint64_t number) {
    at_ns[number % samples_max] = now_ns();
    count.store(count.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
    last.store(number, std::memory_order_release);
  }
};

struct ReaderNotes {
  std::atomic<pid_t> process{0};
  alignas(64) std::atomic<std::size_t> sizes_done{0};  ///< number of sizes whose last message was received
  Receipts receipts[sizes_max];
};

struct SizeResult {
  std::size_t samples = 0;
  double times_us[samples_max] = {};
  double paced_cpu_us = unknown, per_s = unknown, fast_cpu_us = unknown, lost = unknown;
};

struct Board {
  std::atomic<std::size_t> ready{0};  ///< number of readers that know the writer
  /// The number of the last message of each size. The writer sets it after all measurements.
  std::atomic<std::uint64_t> last_number[sizes_max];
  ReaderNotes readers[readers_max];
  SizeResult results[sizes_max];

  Board() {
    for (auto& number : last_number) number = std::numeric_limits<std::uint64_t>::max();
  }
};

}  // namespace sft::bench::peers
