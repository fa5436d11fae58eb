// Detects a connection by which nothing arrives although its writer reports that it sends. Such a connection
// has to be set up anew. One watchdog watches one writer for one of our readers. Pure: the progress that the
// writer's node reports, arrivals and times go in, answers come out.
//
// The watchdog never complains about a pair that works, however quiet, slow, lossy or limited that is:
// - only samples count that were sent after the last arrival, and whole to all readers;
// - where samples may get lost, more of them must be missing than can get lost by chance;
// - the samples that were sent last have time to arrive, and large samples have more time;
// - with a maximum rate only samples count that were reported at least a period apart: those in between may
//   be withheld, also at the end of a burst that nothing follows.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "core/control/control.h"
#include "core/platform/clock.h"

namespace sft::core {

class ArrivalWatchdog {
 public:
  /// If a fifth of all samples gets lost, this many in a row do not get lost within the age of the universe.
  static constexpr std::uint64_t missing_where_lossy = 32;
  static constexpr std::uint64_t missing_where_reliable = 2;
  /// Added to the time that a sample takes on a link with `slowest_bytes_per_s`.
  static constexpr std::chrono::seconds timeout{2};
  static constexpr std::uint64_t slowest_bytes_per_s = 100'000;
  static constexpr std::chrono::seconds timeout_with_history{10};
  static constexpr std::chrono::seconds quiet_after{2};
  static constexpr std::chrono::seconds progress_needed_for{60};
  /// The pause between two restarts, which doubles up to the longest one as long as nothing arrives.
  static constexpr std::chrono::seconds pause_first{1};
  static constexpr std::chrono::seconds pause_longest{60};

  struct Pair {
    bool reliable = false;  ///< samples do not get lost on the way, or are sent again
    std::uint32_t min_period_us = 0;
    bool awaits_history = false;
  };

  /// Must be called when the writer's node has just reported its progress, and about once a second without
  /// progress (null). A progress that was reported before something arrived must not be passed after that.
  /// `signs` changes whenever something from the writer arrives. Returns true if the connection has to be set
  /// up anew. The watchdog then counts as if that was done.
  bool look(const Progress* progress, std::uint64_t signs, const Pair& pair, Time now);
  /// Counting begins again, because there is no connection, or something else explains why nothing arrives.
  void excuse();

  /// Returns true if nothing has arrived for some time, so that the progress of the writer is needed, and for
  /// a while after that. So the reader need not ask each time if a writer sends only now and then.
  bool needs_progress(Time now);
  std::uint64_t restarts() const { return restarts_; }

 private:
  void advance(const Progress& progress, const Pair& pair, Time now);
  bool is_missed(const Pair& pair) const;
  std::chrono::nanoseconds time_to_arrive(const Pair& pair) const;

  std::optional<std::uint64_t> signs_;
  Time arrived_at_{};  ///< when signs_ changed
  Time needs_progress_until_{};
  std::optional<Progress> base_;  ///< the first progress since something arrived
  Progress latest_{};
  std::uint64_t periods_ = 0;  ///< of the maximum rate in which samples were sent since base_
  Time period_at_{};           ///< the end of the last of these periods, or else the time of base_
  std::optional<Time> missed_since_;
  std::chrono::nanoseconds pause_{0};
  Time next_{};  ///< no restart before this
  std::uint64_t restarts_ = 0;
};

}  // namespace sft::core
