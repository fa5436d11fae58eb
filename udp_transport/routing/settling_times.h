// Notes for how long each destination of a writer has had the same request. A destination that has just
// changed the requested fields or parts, or does so often, is in no multicast group, because each change of
// a member makes another group for all members. A new destination only waits until all its readers may have
// sent their requests. Uses no clock, thread or I/O.
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

  /// The request of a destination. A change of any member of this struct makes another group.
  struct Asked {
    std::vector<Selection> selections{};  ///< the selections in any order, each once
    std::uint32_t min_period_us = 0;      ///< maximum rate of the only selection, as a period
    bool reliable = false;
    bool gets_more = false;  ///< true if the destination needs samples that a group does not get
  };

  /// Requests to a new destination within this time do not count as changes, because the requests of its
  /// readers come one after another. After this time the destination counts as calm.
  static constexpr Duration gathering{10};
  /// A known destination counts as calm after this time without a change.
  static constexpr Duration settled_after{100};
  /// After more than `changes_in_a_row` changes, each within `row_pause` of the previous one, each further
  /// change doubles the time, up to `settled_after_longest`.
  static constexpr int changes_in_a_row = 3;
  static constexpr std::chrono::seconds row_pause{5}, settled_after_longest{5};

  /// Notes the present request of a destination. Called between begin_look() and end_look().
  void note(const SocketAddress& to, Asked asked, Time now);
  void begin_look() { ++look_; }
  /// Notes that the destinations without a call of note() have left. They are remembered for `row_pause`,
  /// because coming back is a change.
  void end_look(Time now);

  /// Returns when the destination will be calm if nothing changes until then. REQUIRES: note() was called
  /// for it.
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
