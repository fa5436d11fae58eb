// The samples of a writer that have arrived, have begun to arrive, or are missing, in the order of their
// places. Pure: calls and times in, answers out.
//
// No sample before next() is missing or incomplete. Samples behind it are held back, with a bound on their
// bytes: beyond that the oldest missing sample is lost. So is a sample that the writer no longer has.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/seam/transport.h"
#include "udp_transport/reliable/arrival_limits.h"
#include "udp_transport/reliable/ordinal_ring.h"
#include "udp_transport/reliable/repair_schedule.h"
#include "udp_transport/wire/datagram.h"

namespace sft::udp {

class ArrivedSamples {
 public:
  using Time = std::chrono::steady_clock::time_point;
  using Place = std::uint64_t;

  enum class State : std::uint8_t { missing, begun, whole, passed };
  struct Slot {
    State state = State::missing;
    SampleLabel label{};
    core::SampleHandle sample{};  ///< begun: as far as it has come
    bool makes_no_sense = false;
    RepairSchedule::Entry repair{};
    bool settled() const { return state == State::whole || state == State::passed; }
  };
  struct Gap {
    Place place = 0;
    std::optional<SampleLabel> label{};  ///< empty: nothing of it has come
  };

  explicit ArrivedSamples(const ArrivalLimits& limits)
      : samples_max_(limits.samples), held_bytes_max_(limits.held_bytes), schedule_(limits) {}

  /// Begins with that place, unless there are places already, or they have counted beyond it. Returns true if
  /// it does.
  bool begin_with(Place place);
  /// Knows of all places before `end`, and makes room for them. Returns false if these are too many; then
  /// there is room for those that fit.
  bool reach(Place end, Time now);
  /// The samples before `end` will not come any more. `all_counted`: those that were never known of count as
  /// lost, too.
  void lose_before(Place end, bool all_counted);
  /// Gives up the oldest missing samples while more bytes are held back behind them than may be.
  void hold_no_more_than_allowed();
  /// Lets go of the samples before `end`, which are settled.
  void release_before(Place end);

  // These functions, but for give_back(), ignore a place that is not in slots().

  /// The sample is being put together in that buffer, whose mask and addressee are set.
  void begun(Place place, const SampleLabel& label, core::SampleHandle buffer);
  /// Returns false if the sample is not wanted any more.
  bool whole(Place place, core::SampleHandle sample);
  void pass(Place place);
  /// The datagrams of the sample make no sense: it is asked for again.
  void refuse(Place place);
  /// Notes that each datagram of the sample made sense, but not the sample. Returns true for the second time.
  bool makes_no_sense_again(Place place);
  /// A sample with that low half of a sequence came there. If another one waits there for those before it,
  /// one of both is wrong: it has to come again.
  void unconfirm(Place place, std::uint32_t sequence);
  /// Samples with a greater sequence have a wrong one, and have to come again.
  void distrust_above(std::uint64_t sequence);
  /// The writer says that it has published nothing from that place on. If it said so before, for
  /// OrdinalMonitor::unconfirmed_after, of a place that was known of then, the places from there on are
  /// forgotten: the writer's samples would find them taken.
  void forget_unpublished(Place from, Time now);
  /// The sample begins anew, or another sample begins there.
  void give_back(Place place, Time now);
  /// Some of the sample came once more.
  void came_again(Place place);
  /// Tells that so many parts of the sample were asked for.
  void asked_for(Place place, std::uint32_t parts);

  /// Returns the gaps that have lasted so long that the samples are to be asked for now. `came_at(label)`
  /// tells when the last part of a sample arrived. At most `gaps_max` are asked for at a time: others as
  /// these come. Samples that have begun are given back if nothing gets any further, or where memory is
  /// short: what began them may have claimed much, and not have been true.
  template <class CameAt>
  std::vector<Gap> due_gaps(Time now, const CameAt& came_at, std::size_t gaps_max, bool memory_is_short);
  /// Has somebody call due_gaps() at that time.
  void look_at(Time time) { schedule_.look_at(time, slots_.size()); }
  RepairSchedule& schedule() { return schedule_; }
  const RepairSchedule& schedule() const { return schedule_; }

  /// Samples that had begun: what came of them may be let go of.
  struct Dropped {
    std::vector<SampleLabel> abandoned;   ///< they will not become whole
    std::vector<SampleLabel> given_back;  ///< they begin anew
    bool empty() const { return abandoned.empty() && given_back.empty(); }
  };
  /// Those since the caller emptied it last.
  Dropped& dropped() { return dropped_; }

  const OrdinalRing<Slot>& slots() const { return slots_; }
  Place next() const { return next_; }  ///< the first that is missing or not whole
  Place end() const { return end_; }    ///< behind the last one that is known of
  /// The first that may still come.
  Place first_wanted() const { return std::max(next_, skip_to_); }
  std::size_t held_bytes() const { return held_bytes_; }
  std::uint64_t lost() const { return lost_; }

 private:
  void come_again(Place place);
  void advance();

  const std::size_t samples_max_;
  const std::size_t held_bytes_max_;
  OrdinalRing<Slot> slots_{1};
  Place next_ = 1;
  Place end_ = 1;
  Place skip_to_ = 1;          ///< those before are lost; not above end_
  Place unpublished_end_ = 0;  ///< end_ when the writer said that less was published; 0: it did not
  Time unpublished_since_{};   ///< that time
  std::size_t held_bytes_ = 0;
  std::size_t ready_bytes_ = 0;  ///< of these, before next_
  std::uint64_t lost_ = 0;
  Dropped dropped_;
  RepairSchedule schedule_;
};

template <class CameAt>
std::vector<ArrivedSamples::Gap> ArrivedSamples::due_gaps(Time now, const CameAt& came_at,
                                                          std::size_t gaps_max, bool memory_is_short) {
  std::vector<Gap> gaps;
  std::size_t awaited = 0;  // asked for, and it is too early to ask again
  schedule_.begin_look(now);
  if (schedule_.is_forgotten(now)) return gaps;
  const Place end = slots_.end();
  const bool first_has_begun = next_ < end && slots_[next_].state == State::begun;
  const bool stuck = schedule_.is_stuck(next_, first_has_begun ? came_at(slots_[next_].label) : Time{}, now);
  for (Place place = next_; place < end; ++place) {
    Slot& slot = slots_[place];
    if (slot.settled()) continue;
    Time came = slot.state == State::begun ? came_at(slot.label) : Time{};
    const bool must_go_on = stuck || memory_is_short;
    if (must_go_on && slot.state == State::begun && schedule_.has_timed_out(came, now)) {
      give_back(place, now);
      came = Time{};
    }
    Time due = schedule_.due(slot.repair, came);
    if (due > now) {
      awaited += slot.repair.asked > 0 ? 1 : 0;
    } else if (gaps.size() + awaited >= gaps_max) {
      due = schedule_.soon(now);
    } else {
      gaps.push_back({place, {}});
      if (slot.state == State::begun) gaps.back().label = slot.label;
      due = schedule_.ask(slot.repair, now);
    }
    look_at(due);
  }
  return gaps;
}

}  // namespace sft::udp
