// Counts the announcements that are kept of each participant: each has room for its share in any case, and
// for more while there is room for everybody. Pure.
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

  bool has_room_for(AnnouncerId participant) const {
    const auto share = shares_.find(participant);
    const bool is_within_share = share == shares_.end() || share->second < limits_.share;
    return all_ < limits_.all && (is_within_share || all_ < limits_.crowded);
  }
  void add(AnnouncerId participant) {
    ++all_;
    ++shares_[participant];
  }
  void remove(AnnouncerId participant) {
    --all_;
    const auto share = shares_.find(participant);
    if (--share->second == 0) shares_.erase(share);
  }

 private:
  const Limits limits_;
  std::size_t all_ = 0;
  std::map<AnnouncerId, std::size_t> shares_;
};

}  // namespace sft::core
