// Notes since when each destination of a writer has asked for the same. A destination that has just asked
// for other fields or parts, or does so often, is in no multicast group, because each change of a member
// makes another group for all members. A new destination only waits until all its readers may have asked.
// Uses no clock, thread or I/O.
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

  /// What a destination asks for. A change of any member makes another group.
  struct Asked {
    std::vector<Selection> selections{};  ///< in any order, none twice
    std::uint32_t min_period_us = 0;      ///< maximum rate of the only selection, as a period
    bool reliable = false;
    bool gets_more = false;  ///< the destination is sent more than a group is
  };

  /// Requests to a new destination within this time are no changes, because those of its readers come one
  /// after another. Then the destination counts as calm.
  static constexpr Duration gathering{10};
  /// Any other destination counts as calm after this time without a change.
  static constexpr Duration settled_after{100};
  /// After more than `changes_in_a_row` changes, each within `row_pause` of the one before, each further
  /// change doubles the time, up to `settled_after_longest`.
  static constexpr int changes_in_a_row = 3;
  static constexpr std::chrono::seconds row_pause{5}, settled_after_longest{5};

  /// Notes what is asked for at a destination now. Called between begin_look() and end_look().
  void note(const SocketAddress& to, Asked asked, Time now);
  void begin_look() { ++look_; }
  /// Notes that destinations that were not noted have left. They are remembered for `row_pause`, because to
  /// come back is a change.
  void end_look(Time now);

  /// Returns when the destination will be calm if nothing changes until then. REQUIRES: it was noted.
  Time settled_at(const SocketAddress& to) const { return known_.at(to).settled_at; }

 private:
  struct Known {
    Asked asked;
    Time gathers_until{};
    Time changed_at{};
    Time settled_at{};
    int changes = 0;  ///< changes in a row
    unsigned noted_in = 0;
    bool is_there = true;
  };

  std::map<SocketAddress, Known> known_;
  unsigned look_ = 0;
};

}  // namespace sft::udp
