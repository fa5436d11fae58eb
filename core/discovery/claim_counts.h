// Counts the announcements that are kept of each participant: each has room for its share in any case, and
// for more while there is room for everybody. One with a large description of its type counts as several.
// Pure.
#pragma once

#include <cstddef>
#include <map>

#include "core/control/control.h"

namespace sft::core {

class ClaimCounts {
 public:
  struct Limits {
    std::size_t share = 0;    ///< announcements that each participant may have in any case
    std::size_t crowded = 0;  ///< from so many announcements on a participant gets its share and no more
    std::size_t all = 0;
  };
  explicit ClaimCounts(const Limits& limits) : limits_(limits) {}

  /// True if there is room for an announcement of that weight (claim.h), or for an increase by it.
  bool has_room_for(AnnouncerId participant, std::size_t weight) const {
    const auto share = shares_.find(participant);
    const std::size_t own = share == shares_.end() ? 0 : share->second;
    const bool is_within_share = own + weight <= limits_.share;
    return all_ + weight <= limits_.all && (is_within_share || all_ + weight <= limits_.crowded);
  }
  void add(AnnouncerId participant, std::size_t weight) {
    all_ += weight;
    shares_[participant] += weight;
  }
  void remove(AnnouncerId participant, std::size_t weight) {
    all_ -= weight;
    const auto share = shares_.find(participant);
    share->second -= weight;
    if (share->second == 0) shares_.erase(share);
  }

 private:
  const Limits limits_;
  std::size_t all_ = 0;
  std::map<AnnouncerId, std::size_t> shares_;
};

}  // namespace sft::core
