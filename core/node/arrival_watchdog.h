// Whether nothing arrives of a writer that says that it sends, although the pair counts as connected: then
// the connection is to be set up anew. One writer, as one of our readers hears it. Pure: what the writer's
// node tells of its progress, what has arrived, and times in, answers out.
//
// It never says so of a pair that works, however quiet, slow, lossy or limited it is:
// - what was sent is counted from the last sign of an arrival, in samples that went out whole to all readers;
// - where samples may get lost, so many have to be missing that not all of them can have been lost by chance;
// - what was sent last has time to arrive, and large samples have more;
// - with a maximum rate only samples count that were told of at least a period apart: what is sent in between
//   may be withheld, also at the end of a burst that nothing follows.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "core/control/control.h"

namespace sft::core {

class ArrivalWatchdog {
 public:
  using Now = std::chrono::steady_clock::time_point;
  /// A fifth of all samples may get lost: so many in a row do not within the age of the universe.
  static constexpr std::uint64_t missing_where_lossy = 32;
  static constexpr std::uint64_t missing_where_reliable = 2;
  /// On top of the time that a sample takes on a link with `slowest_bytes_per_s`.
  static constexpr std::chrono::seconds patience{2};
  static constexpr std::uint64_t slowest_bytes_per_s = 100'000;
  static constexpr std::chrono::seconds patience_with_history{10};
  /// Between two restarts; doubles up to the second one as long as nothing arrives.
  static constexpr std::chrono::seconds pause_first{1};
  static constexpr std::chrono::seconds pause_longest{60};

  struct Pair {
    bool reliable = false;  ///< nothing gets lost on the way, or is sent again
    std::uint32_t min_period_us = 0;
    bool awaits_history = false;
  };

  /// To be called for each sign of life of the writer's node. `progress` is null where the node does not name
  /// the writer: it has sent nothing since it was named last. `signs` differs from what it was whenever
  /// something of the writer has arrived meanwhile. Returns whether to set the connection up anew, which then
  /// counts as done.
  bool look(const Progress* progress, std::uint64_t signs, const Pair& pair, Now now);
  /// There is no connection, or something else explains that nothing arrives: counting begins again.
  void excuse();

  std::uint64_t restarts() const { return restarts_; }

 private:
  void advance(const Progress& progress, const Pair& pair, Now now);
  bool is_missed(const Pair& pair) const;
  std::chrono::nanoseconds time_to_arrive(const Pair& pair) const;

  std::optional<std::uint64_t> signs_;
  std::optional<Progress> base_;  ///< what was sent when something arrived last, as far as we were told
  Progress latest_{};
  std::uint64_t periods_ = 0;  ///< of the maximum rate, in which something was sent since base_
  Now period_at_{};            ///< when the last of these ended, or else when we were told of base_
  std::optional<Now> missed_since_;
  std::chrono::nanoseconds pause_{0};
  Now next_{};  ///< not before
  std::uint64_t restarts_ = 0;
};

}  // namespace sft::core
