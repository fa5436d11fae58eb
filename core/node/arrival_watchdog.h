// Detects a connection over which nothing arrives, although its writer reports that it sends samples. Such
// a connection has to be set up anew. One watchdog watches one writer for one reader of this node. It uses
// no clock, thread or I/O: the reported progress of the writer, arrivals and times are passed in, decisions
// are returned.
//
// The watchdog never complains about a pair that works, even if the pair is quiet, slow, lossy or limited:
// - Only samples that were sent after the last arrival, with all fields and to all readers, count. A report
//   is some milliseconds old when it comes, so it counts only if nothing has arrived for longer than that.
// - While the process is stopped, it receives nothing. After that, samples are given time to arrive again,
//   and reports that waited meanwhile do not count.
// - If samples may be lost, more of them must be missing than can be lost by chance.
// - The last samples are given time to arrive, and large samples are given more time.
// - With a maximum rate, only samples that were reported at least one period apart count. Samples in
//   between may be withheld, also at the end of a burst that no further sample follows.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "core/control/control.h"
#include "core/platform/clock.h"

namespace sft::core {

class ArrivalWatchdog {
 public:
  /// The number of consecutive samples that must be missing before a connection is restarted. If a fifth of
  /// all samples is lost, this number of consecutive samples is not lost by chance within the age of the
  /// universe.
  static constexpr std::uint64_t missing_where_lossy = 32;
  static constexpr std::uint64_t missing_where_reliable = 2;
  /// The minimum time that samples are given to arrive. The time that a sample needs on a link with
  /// `slowest_bytes_per_s` is added.
  static constexpr std::chrono::seconds timeout{2};
  static constexpr std::uint64_t slowest_bytes_per_s = 100'000;
  static constexpr std::chrono::seconds timeout_with_history{10};
  static constexpr std::chrono::seconds quiet_after{2};
  /// The maximum age of a report when it comes. Samples that were sent after it may have arrived before it.
  static constexpr std::chrono::milliseconds report_age_max{500};
  /// If there was no look for this time, the process was stopped or got no processor.
  static constexpr std::chrono::seconds stopped_after{5};
  static constexpr std::chrono::seconds progress_needed_for{60};
  /// The pauses between two restarts. As long as nothing arrives, each pause is twice as long as the
  /// previous one, up to the longest.
  static constexpr std::chrono::seconds pause_first{1};
  static constexpr std::chrono::seconds pause_longest{60};

  struct Pair {
    bool reliable = false;  ///< true: samples are not lost on the way, or are sent again
    std::uint32_t min_period_us = 0;
    bool awaits_history = false;
  };

  /// Must be called with the progress whenever a report of the writer's node has come, and about once a
  /// second with null. `signs` must change whenever something from the writer arrives. Returns true if the
  /// connection has to be set up anew. The watchdog then assumes that the caller does this.
  bool look(const Progress* progress, std::uint64_t signs, const Pair& pair, Time now);
  /// Starts counting again. Must be called if there is no connection, or if there is another known reason
  /// why nothing arrives.
  void excuse();

  /// Returns true if the progress of the writer is needed, because nothing has arrived for some time. The
  /// result remains true for a while after that, so that the result does not change with each sample of a
  /// writer that sends only now and then.
  bool needs_progress(Time now);
  std::uint64_t restarts() const { return restarts_; }

 private:
  void advance(const Progress& progress, const Pair& pair, Time now);
  bool is_missed(const Pair& pair) const;
  std::chrono::nanoseconds time_to_arrive(const Pair& pair) const;

  std::optional<std::uint64_t> signs_;
  Time looked_at_{};
  Time arrived_at_{};  ///< the time when signs_ changed last
  Time reports_count_from_{};
  Time needs_progress_until_{};
  std::optional<Progress> base_;  ///< the first progress that was reported since the last arrival
  Progress latest_{};
  /// The number of periods of the maximum rate since base_ in which samples were sent.
  std::uint64_t periods_ = 0;
  Time period_at_{};  ///< the end of the last of these periods, or the time of base_ if there is none
  std::optional<Time> missed_since_;
  std::chrono::nanoseconds pause_{0};
  Time next_{};  ///< the earliest time of the next restart
  std::uint64_t restarts_ = 0;
};

}  // namespace sft::core
