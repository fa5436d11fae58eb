// The observations of one phase, and their summary over several rounds. Pure: no process is run or read
// here.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace sft::bench::isolation {

inline constexpr std::size_t local_readers = 3;
inline constexpr std::size_t remote_reader = local_readers;  ///< the index of the remote reader
inline constexpr std::size_t messages_max = 8192;

/// What the processes of a run have measured, and the flags by which they start together, in memory that all
/// of them share. Arrays are indexed by the number of a message, from 1.
struct Board {
  /// Number of processes that are matched, without the remote reader.
  std::atomic<std::size_t> ready{0};
  std::atomic<bool> begun{false};               ///< true: the publisher may write
  std::atomic<std::uint64_t> written{0};        ///< the number of the last message that was due
  std::atomic<std::uint64_t> remote_latest{0};  ///< the greatest number that the remote reader has read
  std::atomic<bool> remote_matched{false};
  std::int64_t due_ns[messages_max] = {};
  std::int64_t sent_ns[messages_max] = {};  ///< time before the call that writes
  /// Time after that call; 0: the call has not returned.
  std::int64_t returned_ns[messages_max] = {};
  /// Page faults of the thread during that call.
  std::int64_t page_faults[messages_max] = {};
  /// Time of the arrival; 0: the reader has not read the message.
  std::int64_t arrived_ns[local_readers + 1][messages_max] = {};
};

/// The messages of a phase: [first, end).
struct Numbers {
  std::uint64_t first = 0;
  std::uint64_t end = 0;
};

struct Resources {
  double s = 0;
  double local_cpu_s = 0;  ///< processor time of the publisher and the local readers
  double remote_cpu_s = 0;
};

struct Observation {
  /// Times from before the writing call until a local reader has read the message.
  std::vector<double> local_us{};
  std::vector<double> publish_us{};  ///< duration of the writing call
  std::vector<double> late_us{};     ///< delay of each write relative to its planned time
  std::int64_t page_faults = 0;      ///< page faults in all writing calls
  std::size_t lost = 0;              ///< messages that a local reader missed, summed over the local readers
  std::size_t remote_received = 0;
  Resources resources{};
};

Observation observe(const Board& board, const Numbers& numbers, const Resources& resources);

/// Quantiles over several rounds: the medians of the rounds' quantiles, and the worst of all times. NaN
/// without times.
struct Times {
  double p50 = 0;
  double p99 = 0;
  double worst = 0;
  double p99_of_worst_round = 0;
};

Times times_over(std::vector<std::vector<double>> rounds);

struct Summary {
  Times local{};
  Times publish{};
  double published_hz = 0;
  double cpu_percent = 0;  ///< percent of one processor
  double remote_cpu_percent = 0;
  std::int64_t page_faults = 0;
  std::size_t lost = 0;
  std::size_t remote_received = 0;
};

Summary summarize(const std::vector<Observation>& rounds);

/// Returns when a publisher writes next after the turn at `due_ns`. Turns that have passed at `now_ns` are
/// skipped, so that a delayed publisher does not write a burst.
std::int64_t next_turn_ns(std::int64_t due_ns, std::int64_t now_ns, std::int64_t period_ns);

}  // namespace sft::bench::isolation
