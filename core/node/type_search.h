// Decides from when on a node that looks for the type of a topic listens to readers, too. Publishers tell the
// type as well, and a node that has begun to hear all readers never stops: if all nodes that look for types
// did so, they would have to tell each other of all their subscribers. Pure.
#pragma once

#include <algorithm>
#include <chrono>

#include "core/platform/clock.h"

namespace sft::core {

class TypeSearch {
 public:
  /// A publisher that is there has been heard by then.
  static constexpr std::chrono::seconds publishers_first{1};
  /// However many processes start, readers are heard after this time, or half of the time that there is.
  static constexpr std::chrono::seconds readers_after{5};

  TypeSearch(Time now, Time deadline)
      : deadline_(deadline),
        hears_readers_(deadline - now <= publishers_first),
        readers_at_(now + publishers_first),
        readers_at_last_(
            std::max(readers_at_, now + std::min<Time::duration>(readers_after, (deadline - now) / 2))) {}

  bool hears_readers() const { return hears_readers_; }
  /// The time until which the next news are waited for.
  Time waits_until() const { return hears_readers_ ? deadline_ : readers_at_; }
  /// Nothing came until then. `newcomer_at`: when another process was discovered last; while processes start,
  /// a publisher may still come. Returns false if the search is over.
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
