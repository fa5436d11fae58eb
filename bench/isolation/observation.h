// What was seen in one phase, and its summary over several rounds. Pure: nothing is run or read here.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace sft::bench::isolation {

inline constexpr std::size_t local_readers = 3;
inline constexpr std::size_t remote_reader = local_readers;  ///< its place behind the local ones
inline constexpr std::size_t messages_max = 8192;

/// The notes of all processes of a run, in memory that they share. The index in an array is the number of a
/// message. Numbers begin at 1.
struct Board {
  std::atomic<std::size_t> ready{0};            ///< processes that are matched, without the remote reader
  std::atomic<bool> begun{false};               ///< the publisher may write
  std::atomic<std::uint64_t> written{0};        ///< the number of the last message whose turn has come
  std::atomic<std::uint64_t> remote_latest{0};  ///< the greatest number that the remote reader has read
  std::atomic<bool> remote_matched{false};
  std::int64_t due_ns[messages_max] = {};
  std::int64_t sent_ns[messages_max] = {};                        ///< before the call that writes
  std::int64_t returned_ns[messages_max] = {};                    ///< after it; 0: it has not returned
  std::int64_t page_faults[messages_max] = {};                    ///< of the publisher's thread in that call
  std::int64_t arrived_ns[local_readers + 1][messages_max] = {};  ///< 0: not read
};

/// The messages of a phase: [first, end).
struct Numbers {
  std::uint64_t first = 0;
  std::uint64_t end = 0;
};

struct Resources {
  double s = 0;
  double local_cpu_s = 0;  ///< of the publisher and the local readers
  double remote_cpu_s = 0;
};

struct Observation {
  std::vector<double> local_us{};  ///< from before the call that writes until a local reader has the message
  std::vector<double> publish_us{};  ///< the time of that call
  std::vector<double> late_us{};     ///< how much later than planned the publisher ran
  std::int64_t page_faults = 0;      ///< of all these calls
  std::size_t lost = 0;              ///< messages that a local reader did not get, counted for each reader
  std::size_t remote_received = 0;
  Resources resources{};
};

Observation observe(const Board& board, const Numbers& numbers, const Resources& resources);

/// Quantiles of the rounds: the medians over the rounds, and the worst of all times. Not a number without
/// times.
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
  double cpu_percent = 0;  ///< of one processor
  double remote_cpu_percent = 0;
  std::int64_t page_faults = 0;
  std::size_t lost = 0;
  std::size_t remote_received = 0;
};

Summary summarize(const std::vector<Observation>& rounds);

/// The next turn of a publisher after the one at `due_ns`. Turns that are over by `now_ns` are left out, so
/// that a publisher that was held up does not write a burst.
std::int64_t next_turn_ns(std::int64_t due_ns, std::int64_t now_ns, std::int64_t period_ns);

}  // namespace sft::bench::isolation
