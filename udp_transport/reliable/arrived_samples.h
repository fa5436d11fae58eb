// The samples of a writer that have arrived, have begun to arrive, or are missing, in the order of their
// places (numbers over all channels of the writer). Uses no clock, thread or I/O.
//
// No sample before the place next() is missing or incomplete. Samples after that place are held back. If
// their bytes exceed a limit, the oldest missing sample is given up as lost. A sample that the writer no
// longer keeps is lost, too.
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
    core::SampleHandle sample{};  ///< the buffer of an incomplete sample, or the whole sample
    bool makes_no_sense = false;
    RepairSchedule::Entry repair{};
    bool settled() const { return state == State::whole || state == State::passed; }
  };
  struct Gap {
    Place place = 0;
    /// The label of the encoding of which a part has come; empty if no part of the sample has come.
    std::optional<SampleLabel> label{};
  };

  explicit ArrivedSamples(const ArrivalLimits& limits)
      : samples_max_(limits.samples), held_bytes_max_(limits.held_bytes), schedule_(limits) {}

  /// Lets the samples begin with `place` and returns true. Returns false if samples are known already, or if
  /// next() is greater than `place`.
  bool begin_with(Place place);
  /// Adds all unknown places below `end` as missing samples. Returns false if ArrivalLimits::samples does
  /// not allow all of them. Then only as many as allowed are added.
  bool reach(Place end, Time now);
  /// Gives up the missing samples before the place `end`. Called if they will not come any more. If
  /// `all_counted` is true, samples that were never added count as lost, too.
  void lose_before(Place end, bool all_counted);
  /// Gives up the oldest missing samples until the later samples, which are held back for them, take no more
  /// bytes than allowed.
  void hold_no_more_than_allowed();
  /// Releases the samples before the place `end`. All of them must be whole or passed.
  void release_before(Place end);

  // The following functions, except give_back(), ignore a place that is not in slots().

  /// Notes that the sample is being assembled in `buffer`. The mask and the addressee of the buffer must be
  /// set.
  void begun(Place place, const SampleLabel& label, core::SampleHandle buffer);
  /// Notes that the whole sample has come. Returns false if the sample is not needed any more.
  bool whole(Place place, core::SampleHandle sample);
  void pass(Place place);
  /// Requests the sample again. Called if its datagrams are invalid.
  void refuse(Place place);
  /// Notes that the sample is invalid although each of its datagrams is valid. Returns true if that was
  /// noted for this sample before.
  bool makes_no_sense_again(Place place);
  /// Notes that a sample came for `place` whose sequence has the low half `sequence`. If the place has a
  /// sample with a different sequence, one of the two samples is wrong, and the sample is requested again.
  void unconfirm(Place place, std::uint32_t sequence);
  /// Requests the samples with a sequence greater than `sequence` again. Called if these sequences are
  /// wrong.
  void distrust_above(std::uint64_t sequence);
  /// Notes the writer's statement that it has published no sample at `from` or a later place. If the writer
  /// has repeated that for OrdinalMonitor::unconfirmed_after, removes the places from `from` on that were
  /// known at the first statement. If they stayed, the writer's next samples would find these places
  /// occupied.
  void forget_unpublished(Place from, Time now);
  /// Notes that the parts of the sample at that place are discarded, because the sample, or another sample,
  /// begins there anew.
  void give_back(Place place, Time now);
  /// Notes that a part of the sample came although it had come before.
  void came_again(Place place);
  /// Notes that `parts` parts of the sample were requested.
  void asked_for(Place place, std::uint32_t parts);

  /// Returns the gaps whose samples should be requested now, because they have lasted long enough.
  /// `came_at(label)` returns the time when the last part of a sample arrived. At most `gaps_max` samples
  /// are requested at a time; further samples are requested when these have come. If no sample makes
  /// progress, or if memory is short, incomplete samples without progress are discarded and begin anew:
  /// their first datagrams may have been wrong.
  template <class CameAt>
  std::vector<Gap> due_gaps(Time now, const CameAt& came_at, std::size_t gaps_max, bool memory_is_short);
  /// Schedules a call of due_gaps() at that time.
  void look_at(Time time) { schedule_.look_at(time, slots_.size()); }
  RepairSchedule& schedule() { return schedule_; }
  const RepairSchedule& schedule() const { return schedule_; }

  /// Incomplete samples whose parts can be released now.
  struct Dropped {
    std::vector<SampleLabel> abandoned;   ///< samples that will not become whole
    std::vector<SampleLabel> given_back;  ///< samples that will come anew
    bool empty() const { return abandoned.empty() && given_back.empty(); }
  };
  /// Returns the samples that were dropped since the caller last cleared this object.
  Dropped& dropped() { return dropped_; }

  const OrdinalRing<Slot>& slots() const { return slots_; }
  Place next() const { return next_; }  ///< the first place whose sample is missing or incomplete
  Place end() const { return end_; }    ///< the place after the last known one
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
  Place skip_to_ = 1;  ///< samples before this place are given up; at most `end_`
  /// `end_` at the time of the writer's statement that it has published less; 0: no such statement.
  Place unpublished_end_ = 0;
  Time unpublished_since_{};  ///< time of that statement
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
  std::size_t awaited = 0;  // number of samples whose last request is too recent for a new request
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
