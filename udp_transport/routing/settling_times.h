// Measures for how long each destination of a writer has had the same request. A destination that has just
// changed its request, or changes it often, is in no multicast group, because each change of a member makes
// a new group for all members. A new destination only waits until all its readers may have sent their
// requests. Uses no clock, thread or I/O.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <vector>

#include "sft/selection.h"
#include "udp_transport/io/datagram_io.h"

namespace sft::udp {

class SettlingTimes {
 public:
  using Time = std::chrono::steady_clock::time_point;
  using Duration = std::chrono::milliseconds;

  /// The request of a destination. A change of any member of this struct would make a new group.
  struct Asked {
    std::vector<Selection> selections{};  ///< the selections in any order, without duplicates
    std::uint32_t min_period_us = 0;      ///< maximum rate of the only selection, as a period
    bool reliable = false;
    bool gets_more = false;  ///< true if the destination needs samples that a group does not get
  };

  /// Requests to a new destination within this time do not count as changes, because the requests of its
  /// readers come one after another. After this time the destination counts as settled.
  static constexpr Duration gathering{10};
  /// A known destination counts as settled after this time without a change.
  static constexpr Duration settled_after{100};
  /// If more than `changes_in_a_row` changes follow each other within `row_pause`, each further change
  /// doubles the time `settled_after`, up to `settled_after_longest`.
  static constexpr int changes_in_a_row = 3;
  static constexpr std::chrono::seconds row_pause{5}, settled_after_longest{5};

  /// Notes the present request of a destination. Must be called between begin_look() and end_look().
  void note(const SocketAddress& to, Asked asked, Time now);
  void begin_look() { ++look_; }
  /// Notes that the destinations for which note() was not called since begin_look() have left. They are kept
  /// for `row_pause`, because a return counts as a change.
  void end_look(Time now);

  /// Returns the time from which the destination counts as settled if its request does not change before.
  /// REQUIRES: note() was called for the destination.
  Time settled_at(const SocketAddress& to) const { return known_.at(to).settled_at; }

 private:
  struct Known {
    Asked asked;
    Time gathers_until{};
    Time changed_at{};
    Time settled_at{};
    int changes = 0;  ///< number of changes in a row
    unsigned noted_in = 0;
    bool is_there = true;
  };

  std::map<SocketAddress, Known> known_;
  unsigned look_ = 0;
};

}  // namespace sft::udp
