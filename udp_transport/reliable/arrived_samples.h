// The samples of a writer that have arrived, have begun to arrive, or are missing, in the order of their
// places. Uses no clock, thread or I/O.
//
// No sample before next() is missing or incomplete. Samples behind next() are held back, with a limit on
// their bytes. If they exceed it, the oldest missing sample is lost. A sample that the writer no longer has
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
    /// Label of the encoding that has begun to come; empty: nothing of the sample has come.
    std::optional<SampleLabel> label{};
  };

  explicit ArrivedSamples(const ArrivalLimits& limits)
      : samples_max_(limits.samples), held_bytes_max_(limits.held_bytes), schedule_(limits) {}

  /// Makes `place` the first place and returns true. Returns false if there are places already, or if
  /// next() is behind `place`.
  bool begin_with(Place place);
  /// Adds all places before `end`. Returns false if there is no room for all of them; then those that fit
  /// are added.
  bool reach(Place end, Time now);
  /// Gives up the samples before `end`, which will not come any more. If `all_counted`, samples without a
  /// place count as lost, too.
  void lose_before(Place end, bool all_counted);
  /// Gives up the oldest missing samples while the samples behind them hold more bytes than allowed.
  void hold_no_more_than_allowed();
  /// Releases the samples before `end`, all of which are whole or passed.
  void release_before(Place end);

  // The following functions, except give_back(), ignore a place that is not in slots().

  /// Notes that the sample is being assembled in that buffer, whose mask and addressee are set.
  void begun(Place place, const SampleLabel& label, core::SampleHandle buffer);
  /// Notes a whole sample. Returns false if the sample is not needed any more.
  bool whole(Place place, core::SampleHandle sample);
  void pass(Place place);
  /// Requests the sample again, because its datagrams are invalid.
  void refuse(Place place);
  /// Notes that the sample is invalid although each of its datagrams is valid. Returns true the second
  /// time.
  bool makes_no_sense_again(Place place);
  /// Notes that a sample with that low half of a sequence came for that place. If another sample is at that
  /// place, one of the two is wrong, and the place has to be filled again.
  void unconfirm(Place place, std::uint32_t sequence);
  /// Requests again the samples with a greater sequence, because their sequences are wrong.
  void distrust_above(std::uint64_t sequence);
  /// Notes the writer's statement that it has published nothing from `from` on. If the same was stated for
  /// OrdinalMonitor::unconfirmed_after, the places from there on that were known at the first statement are
  /// removed. Otherwise the writer's next samples would find these places occupied.
  void forget_unpublished(Place from, Time now);
  /// Notes that the sample at that place begins anew, or that another sample begins there.
  void give_back(Place place, Time now);
  /// Notes that a part of the sample came once more.
  void came_again(Place place);
  /// Notes that `parts` parts of the sample were requested.
  void asked_for(Place place, std::uint32_t parts);

  /// Returns the gaps that have lasted so long that their samples should be requested now. `came_at(label)`
  /// returns when the last part of a sample arrived. At most `gaps_max` samples are requested at a time,
  /// and further ones when these have come. Samples that have begun are given back if nothing makes
  /// progress, or if memory is short, because the datagrams that began them may have been wrong.
  template <class CameAt>
  std::vector<Gap> due_gaps(Time now, const CameAt& came_at, std::size_t gaps_max, bool memory_is_short);
  /// Schedules a call of due_gaps() at that time.
  void look_at(Time time) { schedule_.look_at(time, slots_.size()); }
  RepairSchedule& schedule() { return schedule_; }
  const RepairSchedule& schedule() const { return schedule_; }

  /// Samples that had begun, and whose parts can be released now.
  struct Dropped {
    std::vector<SampleLabel> abandoned;   ///< samples that will not become whole
    std::vector<SampleLabel> given_back;  ///< samples that begin anew
    bool empty() const { return abandoned.empty() && given_back.empty(); }
  };
  /// Returns the samples that were dropped since the caller last cleared this object.
  Dropped& dropped() { return dropped_; }

  const OrdinalRing<Slot>& slots() const { return slots_; }
  Place next() const { return next_; }  ///< the first place whose sample is missing or incomplete
  Place end() const { return end_; }    ///< the place behind the last known one
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
  Place skip_to_ = 1;          ///< samples before this place are lost; at most `end_`
  Place unpublished_end_ = 0;  ///< `end_` when the writer stated that it had published less; 0: it did not
  Time unpublished_since_{};   ///< time of that statement
  std::size_t held_bytes_ = 0;
  std::size_t ready_bytes_ = 0;  ///< the part of `held_bytes_` for samples before `next_`
  std::uint64_t lost_ = 0;
  Dropped dropped_;
  RepairSchedule schedule_;
};

template <class CameAt>
std::vector<ArrivedSamples::Gap> ArrivedSamples::due_gaps(Time now, const CameAt& came_at,
                                                          std::size_t gaps_max, bool memory_is_short) {
  std::vector<Gap> gaps;
  std::size_t awaited = 0;  // number of samples whose last request is too recent for another one
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
