// The samples of a writer that have arrived, have begun to arrive, or are missing, in the order of their
// places. Uses no clock, thread or I/O.
//
// No sample before next() is missing or incomplete. Samples behind next() are held back, with a limit on
// their bytes. Beyond that limit the oldest missing sample is lost. A sample that the writer no longer has
// is lost, too.
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
    core::SampleHandle sample{};  ///< the buffer of a sample that has begun, or the whole sample
    bool makes_no_sense = false;
    RepairSchedule::Entry repair{};
    bool settled() const { return state == State::whole || state == State::passed; }
  };
  struct Gap {
    Place place = 0;
    std::optional<SampleLabel> label{};  ///< empty: nothing of the sample has come
  };

  explicit ArrivedSamples(const ArrivalLimits& limits)
      : samples_max_(limits.samples), held_bytes_max_(limits.held_bytes), schedule_(limits) {}

  /// Makes `place` the first place and returns true. Returns false if there are places already, or if
  /// next() is behind it.
  bool begin_with(Place place);
  /// Adds all places before `end`. Returns false if there is no room for all of them; then those that fit
  /// are added.
  bool reach(Place end, Time now);
  /// Gives up the samples before `end`, which will not come any more. `all_counted`: those without a place
  /// yet count as lost, too.
  void lose_before(Place end, bool all_counted);
  /// Gives up the oldest missing samples while the samples behind them hold more bytes than allowed.
  void hold_no_more_than_allowed();
  /// Releases the samples before `end`, all of which are whole or passed.
  void release_before(Place end);

  // These functions, except give_back(), ignore a place that is not in slots().

  /// Notes that the sample is being put together in that buffer, whose mask and addressee are set.
  void begun(Place place, const SampleLabel& label, core::SampleHandle buffer);
  /// Notes a whole sample. Returns false if it is not wanted any more.
  bool whole(Place place, core::SampleHandle sample);
  void pass(Place place);
  /// Asks for the sample again, because its datagrams make no sense.
  void refuse(Place place);
  /// Notes that the sample makes no sense although each of its datagrams does. Returns true the second
  /// time.
  bool makes_no_sense_again(Place place);
  /// Notes that a sample with that low half of a sequence came for that place. If another sample waits
  /// there, one of the two is wrong, and the place has to be filled again.
  void unconfirm(Place place, std::uint32_t sequence);
  /// Asks again for samples with a greater sequence, because these sequences are wrong.
  void distrust_above(std::uint64_t sequence);
  /// Notes that the writer has published nothing from `from` on. If it said so for
  /// OrdinalMonitor::unconfirmed_after, of places that were known when it said so first, these places are
  /// removed. Otherwise the writer's own samples would find them occupied.
  void forget_unpublished(Place from, Time now);
  /// Notes that the sample begins anew, or that another sample begins there.
  void give_back(Place place, Time now);
  /// Notes that a part of the sample came once more.
  void came_again(Place place);
  /// Notes that `parts` parts of the sample were asked for.
  void asked_for(Place place, std::uint32_t parts);

  /// Returns the gaps that have lasted so long that their samples are to be asked for now. `came_at(label)`
  /// returns when the last part of a sample arrived. At most `gaps_max` samples are asked for at a time,
  /// and further ones as these come. Samples that have begun are given back if nothing makes progress, or
  /// if memory is short, because the datagrams that began them may have been wrong.
  template <class CameAt>
  std::vector<Gap> due_gaps(Time now, const CameAt& came_at, std::size_t gaps_max, bool memory_is_short);
  /// Schedules a call of due_gaps() at that time.
  void look_at(Time time) { schedule_.look_at(time, slots_.size()); }
  RepairSchedule& schedule() { return schedule_; }
  const RepairSchedule& schedule() const { return schedule_; }

  /// Samples that had begun, and whose parts may be released.
  struct Dropped {
    std::vector<SampleLabel> abandoned;   ///< samples that will not become whole
    std::vector<SampleLabel> given_back;  ///< samples that begin anew
    bool empty() const { return abandoned.empty() && given_back.empty(); }
  };
  /// Returns the samples dropped since the caller cleared this last.
  Dropped& dropped() { return dropped_; }

  const OrdinalRing<Slot>& slots() const { return slots_; }
  Place next() const { return next_; }  ///< the first place that is missing or not whole
  Place end() const { return end_; }    ///< behind the last known place
  /// Returns the first place whose sample may still come.
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
  Place skip_to_ = 1;          ///< samples before this are lost; at most `end_`
  Place unpublished_end_ = 0;  ///< `end_` when the writer said that it had published less; 0: it did not
  Time unpublished_since_{};   ///< time when the writer said that
  std::size_t held_bytes_ = 0;
  std::size_t ready_bytes_ = 0;  ///< part of `held_bytes_` before `next_`
  std::uint64_t lost_ = 0;
  Dropped dropped_;
  RepairSchedule schedule_;
};

template <class CameAt>
std::vector<ArrivedSamples::Gap> ArrivedSamples::due_gaps(Time now, const CameAt& came_at,
                                                          std::size_t gaps_max, bool memory_is_short) {
  std::vector<Gap> gaps;
  std::size_t awaited = 0;  // samples that were asked for too recently to ask again
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
