// Notes since when each destination of a writer has asked for the same. One that has just asked for other
// fields or parts, or does so often, is in no multicast group: each change of a member makes another group
// for all of them. A new destination only has the time to say what all its readers ask for. Pure: what is
// asked for and times go in, answers come out.
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

  /// A change of one of these makes another group.
  struct Asked {
    std::vector<Selection> selections{};  ///< in any order, none twice
    std::uint32_t min_period_us = 0;      ///< of a reader that asks for the only one of them
    bool reliable = false;
    bool gets_more = false;  ///< than a group is sent
  };

  /// What a new destination asks for within this time is no change: the requests of its readers come one
  /// after another. Then it counts as calm.
  static constexpr Duration gathering{10};
  /// Another destination counts as calm after so long without a change.
  static constexpr Duration settled_after{100};
  /// After more than `changes_in_a_row` changes, each within `row_pause` of the one before, each further
  /// change doubles the time, up to `settled_after_longest`.
  static constexpr int changes_in_a_row = 3;
  static constexpr std::chrono::seconds row_pause{5}, settled_after_longest{5};

  /// Notes what is asked for there now. Called between begin_look() and end_look().
  void note(const SocketAddress& to, Asked asked, Time now);
  void begin_look() { ++look_; }
  /// A destination that was not noted has left. It is remembered for `row_pause`: to come back is a change.
  void end_look(Time now);

  /// Returns when it will be calm if nothing changes until then. REQUIRES: it was noted.
  Time settled_at(const SocketAddress& to) const { return known_.at(to).settled_at; }

 private:
  struct Known {
    Asked asked;
    Time gathers_until{};
    Time changed_at{};
    Time settled_at{};
    int changes = 0;  ///< in a row
    unsigned noted_in = 0;
    bool is_there = true;
  };

  std::map<SocketAddress, Known> known_;
  unsigned look_ = 0;
};

}  // namespace sft::udp
