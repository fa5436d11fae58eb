// Decides when a node that searches for the type of a topic begins to read the announcements of readers,
// too. Publishers announce the type as well, and a node that has begun to read the announcements of all
// readers never stops. If all nodes that search for types read the announcements of readers, all nodes
// would have to announce all their subscribers to each other. Uses no clock, thread or I/O.
#pragma once

#include <algorithm>
#include <chrono>

#include "core/platform/clock.h"

namespace sft::core {

class TypeSearch {
 public:
  /// The time after which the announcements of all existing publishers have arrived.
  static constexpr std::chrono::seconds publishers_first{1};
  /// The latest time at which readers are included, even if further processes start. If half of the time
  /// for the search is less than this, it is used instead.
  static constexpr std::chrono::seconds readers_after{5};

  TypeSearch(Time now, Time deadline)
      : deadline_(deadline),
        hears_readers_(deadline - now <= publishers_first),
        readers_at_(now + publishers_first),
        readers_at_last_(
            std::max(readers_at_, now + std::min<Time::duration>(readers_after, (deadline - now) / 2))) {}

  bool hears_readers() const { return hears_readers_; }
  /// Returns the time at which the present wait for announcements ends.
  Time waits_until() const { return hears_readers_ ? deadline_ : readers_at_; }
  /// Must be called if the type was not found by the time waits_until(). `newcomer_at` is the time at which
  /// the last process was discovered; the search waits longer while processes start, since a publisher may
  /// still appear. Returns false if the search is over.
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
