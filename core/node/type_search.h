// Decides when a node that searches for the type of a topic begins to read the announcements of readers, too.
// Publishers announce the type as well, and a node that has begun to read those of all readers never stops.
// If all nodes that search for types did so, they would have to announce all their subscribers to each other.
// Uses no clock, thread or I/O.
#pragma once

#include <algorithm>
#include <chrono>

#include "core/platform/clock.h"

namespace sft::core {

class TypeSearch {
 public:
  /// By then, the announcement of each publisher that exists has come.
  static constexpr std::chrono::seconds publishers_first{1};
  /// However many processes start, readers are included after this time, or after half of the time for the
  /// search.
  static constexpr std::chrono::seconds readers_after{5};

  TypeSearch(Time now, Time deadline)
      : deadline_(deadline),
        hears_readers_(deadline - now <= publishers_first),
        readers_at_(now + publishers_first),
        readers_at_last_(
            std::max(readers_at_, now + std::min<Time::duration>(readers_after, (deadline - now) / 2))) {}

  bool hears_readers() const { return hears_readers_; }
  /// Returns the time until which to wait for announcements.
  Time waits_until() const { return hears_readers_ ? deadline_ : readers_at_; }
  /// Must be called if the type was not found until then. `newcomer_at`: when another process was discovered
  /// last; while processes start, a publisher may still come. Returns false if the search is over.
  bool goes_on(Time now, Time newcomer_at) {
    if (hears_readers_) return false;
    readers_at_ = std::clamp(newcomer_at + publishers_first, readers_at_, readers_at_last_);
    hears_readers_ = now >= readers_at_;
    return true;
  }

 private:
  Time deadline_;
  bool hears_readers_;
  Time readers_at_;
  Time readers_at_last_;
};

}  // namespace sft::core
