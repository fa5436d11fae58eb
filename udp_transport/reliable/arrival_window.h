// The reader's end of a channel (wire_format.md): which samples have come, which are missing and when to ask
// for them, and who of this process has got which, in order. Pure: calls and times in, answers out.
//
// Places count up over all channels of a writer, one after the other: ordinal and place differ by what the
// channels before had.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include "core/seam/transport.h"
#include "udp_transport/reliable/channel_watch.h"
#include "udp_transport/reliable/ordinal_ring.h"
#include "udp_transport/reliable/ordinal_watch.h"
#include "udp_transport/wire/datagram.h"

namespace sft::udp {

struct ArrivalLimits {
  std::size_t samples = 4096;                          ///< from the first missing one on
  std::size_t held_bytes = std::size_t{64} << 20;      ///< of whole samples behind one that is missing
  std::size_t awaited_bytes = std::size_t{128} << 20;  ///< of those that readers have no room for
  std::size_t ack_bytes = std::size_t{1} << 20;        ///< so many are acknowledged unasked
  std::chrono::milliseconds ask_after{2};              ///< something was noticed to be missing; at the least
  std::chrono::milliseconds ask_again_longest{250};
  /// A sample that has begun is given up, and begun anew, if neither it nor the first missing one gets any
  /// further for so long, although the writer is heard: what began it may not have been true.
  std::chrono::milliseconds claim_patience{300};
  std::chrono::seconds forget_after{5};  ///< without a word from the writer nothing is asked for any more
  std::chrono::milliseconds spread{8};   ///< of what many may miss: later by up to so much, at random
  std::uint32_t seed = 1;                ///< of that
};

class ArrivalWindow {
 public:
  using Time = std::chrono::steady_clock::time_point;
  using Place = std::uint64_t;

  explicit ArrivalWindow(const ArrivalLimits& limits)
      : limits_(limits), delay_(limits.ask_after), random_(limits.seed) {}

  /// The progress of a window when nobody heard the writer any more.
  struct Mark {
    std::uint32_t channel = 0;
    std::uint64_t end = 0;  ///< ordinal behind the last one that was known of
  };
  std::optional<Mark> mark() const;
  /// A new window, of a writer that is heard again. In the same channel it begins with the first sample that
  /// it hears of, not with those that were sent meanwhile.
  void join(const Mark& left);

  /// The treatment of a first datagram.
  enum class Standing : std::uint8_t {
    wanted,
    known,   ///< it, or its whole sample, has come already, or is not wanted any more
    beyond,  ///< it is of a channel of before, or there is no room for it; it will come again
  };
  struct Met {
    Standing standing{};
    Place place = 0;
  };
  /// `same_datagram`: the last one that was met came in the same datagram.
  Met meet(const ChannelMark& mark, Time now, bool same_datagram = false);

  // These functions are about a place that was met.

  /// Tells that its sample is being put together in that buffer, whose mask and addressee are set.
  void begun(Place place, const SampleLabel& label, core::SampleHandle buffer);
  void whole(Place place, core::SampleHandle sample);
  /// Tells that its sample will not come, or is for nobody here.
  void pass(Place place);
  /// Tells that the datagrams of its sample make no sense. The sample is asked for again.
  void refuse(Place place);
  /// The same, of a sample of which each datagram made sense: after the second time it is passed over.
  void refuse_or_pass(Place place);
  /// Samples with a greater sequence have a wrong one, and have to come again.
  void distrust_above(std::uint64_t sequence);
  /// A sample with that low half of a sequence came there. If another one waits there for those before it,
  /// one of both is wrong: it has to come again.
  void doubt(Place place, std::uint32_t sequence);
  /// The sample that has begun there; empty if none has, or it is whole.
  std::optional<SampleLabel> begun_at(Place place) const;
  /// Tells that its sample begins anew, or another sample begins there.
  void give_back(Place place, Time now) { give_back(slots_[place], now); }
  /// Some of it came once more.
  void came_again(Place place);

  void hear(const Heartbeat& heartbeat, Time now);
  /// Samples that had begun, and will not become whole: what came of them may be let go of. Since last asked.
  std::vector<SampleLabel> take_abandoned() { return std::exchange(abandoned_, {}); }
  bool has_abandoned() const { return !abandoned_.empty(); }
  /// Samples that had begun, and begin anew: what came of them may be let go of. Since last asked.
  std::vector<SampleLabel> take_given_back() { return std::exchange(given_back_, {}); }
  bool has_given_back() const { return !given_back_.empty(); }

  /// The next sample for that reader, in order; empty if there is none as yet. `accepts(buffer, request)`
  /// tells whether one is for it, once anything of it has come; those of its requests before `request` are
  /// over.
  template <class Accepts>
  core::SampleHandle next(core::EndpointId reader, const Accepts& accepts);
  /// Sets who reads from now on. New readers begin with the first sample that has not arrived yet.
  void set_readers(const std::vector<core::EndpointId>& readers);
  /// Tells that the writer's samples are by now for that reader under that request, or a later one. Samples
  /// that were published before may be under way for any time: up to the position that the next heartbeat
  /// gives for the writer.
  void heard(core::EndpointId reader, std::uint64_t request);
  /// Lets go of what all of them have.
  void release();

  /// The writer waits for readers: what they have not got is not acknowledged, though it has come.
  void set_awaited(bool awaited) { awaited_ = awaited; }
  /// Something is there that not all of them have, after release().
  bool holds_back() const { return slots_.begin() < next_; }
  /// True if the window goes on without lagging readers, or holds too much for them: they have to be given
  /// some.
  bool overtakes() const { return overtakes_; }

  // Asking.

  struct Gap {
    std::uint64_t ordinal = 0;
    Place place = 0;
    std::optional<SampleLabel> label{};  ///< empty: nothing of it has come
  };
  /// Returns the gaps that have lasted so long that the samples are to be asked for now. `came_at(label)`
  /// tells when the last part of a sample arrived. At most `gaps_max` are asked for at a time: others as
  /// these come.
  template <class CameAt>
  std::vector<Gap> due_gaps(Time now, const CameAt& came_at, std::size_t gaps_max);

  /// Others get the same, and may miss the same at the same time: asks at times of its own from now on.
  void spread_asking() { spread_ = limits_.spread; }

  /// Tells that so many parts of its sample were asked for.
  void asked_for(Place place, std::uint32_t parts);

  /// True if something is to be acknowledged now.
  bool ack_due() const {
    return ack_wanted_ || unacked_bytes_ >= limits_.ack_bytes || unacked_ >= acked_at_once;
  }
  /// Returns an ack without the missing samples; it counts as sent.
  Ack ack(std::uint32_t writer);
  /// The time when due_gaps() may find something; Time::max() if never.
  Time next_look() const { return look_at_; }

  bool knows_channel() const { return channels_.present().has_value(); }
  const ChannelWatch& channels() const { return channels_; }
  Place next_place() const { return next_; }
  std::size_t held_bytes() const { return held_bytes_; }
  std::size_t size() const { return slots_.size(); }
  std::uint64_t lost() const { return lost_; }

 private:
  enum class State : std::uint8_t { missing, begun, whole, passed };
  struct Slot {
    State state = State::missing;
    SampleLabel label{};
    core::SampleHandle sample{};  ///< begun: as far as it has come
    std::uint8_t asked = 0;       ///< times, since something of it came
    bool refused = false;         ///< once
    std::uint32_t parts = 0;  ///< of it that were asked for last, less those of which something came again
    Time asked_at{};
    Time ask_at{};
    Time::duration apart{};  ///< later than others may ask
  };
  Time::duration apart() {
    return spread_.count() == 0
               ? spread_
               : Time::duration(std::uniform_int_distribution<Time::rep>(0, spread_.count())(random_));
  }
  static constexpr std::size_t acked_at_once = 1024;
  static constexpr Place no_place = std::numeric_limits<Place>::max();

  /// No writer keeps more samples than this, so no heartbeat spans more.
  static constexpr std::uint64_t kept_max = OrdinalWatch::remembered;

  bool turn_to(const ChannelWatch::Claim& claim, Time now);
  void begin_channel(std::uint64_t ordinal);
  void go_back_to(std::uint64_t ordinal);
  Place place_of(std::uint64_t ordinal) const { return base_ + std::max(ordinal, first_ordinal_); }
  std::uint64_t ordinal_of(Place place) const { return place - base_; }
  Met meet_passed_over(const ChannelMark& mark, Time now, bool same_datagram);
  bool follow(const Heartbeat& heartbeat, Time heard_before, Time now);
  bool contradicts(const Heartbeat& heartbeat, Time now);
  bool was_never_published(const Heartbeat& heartbeat, Time now);
  void ask_for_next(Time now);
  void give_back(Slot& slot, Time now);
  void come_again(Place place);
  bool is_stuck(Time head_came, Time now);
  bool reach(Place end, Time now);
  void settle(Slot& slot, State state);
  void advance();
  void hold_no_more_than_allowed();
  void begin_with(Place place);
  void end_requests(Place published);
  void lose_before(Place end);
  void lose(Slot& slot);
  Place first_not_taken() const;
  /// If there is much to look at, it is not looked at too often.
  void look_at(Time time) {
    constexpr std::size_t few = 256;
    constexpr std::chrono::microseconds pause{500};
    look_at_ = std::min(look_at_, slots_.size() <= few ? time : std::max(time, looked_at_ + pause));
  }

  const ArrivalLimits limits_;
  ChannelWatch channels_;
  OrdinalWatch ordinals_;
  bool joining_ = false;        ///< nothing was heard yet since join()
  std::uint64_t end_said_ = 0;  ///< by a heartbeat, less than what has come; 0: none was
  Time end_said_since_{};
  bool fresh_ = true;                  ///< no ordinal of the channel is known yet
  Place base_ = 0;                     ///< place of ordinal 0 of the channel, modulo 2^64
  std::uint64_t first_ordinal_ = 1;    ///< of the channel, as far as it is followed
  std::uint64_t not_told_before_ = 0;  ///< what heartbeats say of ordinals before this one is no news
  OrdinalRing<Slot> slots_{1};
  Place next_ = 1;     ///< the first that is missing or not whole
  Place end_ = 1;      ///< behind the last one that is known of
  Place skip_to_ = 1;  ///< those before are lost
  struct Reader {
    core::EndpointId id = 0;
    Place place = 0;                 ///< the next that it has not got
    std::uint64_t request = 0;       ///< earlier ones are over
    std::uint64_t heard = 0;         ///< the writer knows of this one
    std::uint64_t next_request = 0;  ///< begins at
    Place next_from = no_place;      ///< that place
    void turn() {
      if (place < next_from) return;
      request = next_request;
      next_from = no_place;
    }
  };
  std::vector<Reader> readers_;
  std::size_t held_bytes_ = 0;
  std::size_t ready_bytes_ = 0;  ///< of these, before the first that is missing
  bool awaited_ = false;
  bool overtakes_ = false;
  Place acked_ = 1;
  bool acked_all_ = true;
  std::uint64_t lost_ = 0;
  std::vector<SampleLabel> abandoned_, given_back_;
  Place looked_at_next_ = 0;  ///< next_ when it was looked at last
  Time next_since_{};         ///< the time from which on it was the same
  Time looked_at_{};

  Time heard_at_{};
  Time look_at_ = Time::max();
  Time::duration delay_;  ///< before asking: grows where that was too early
  Time::duration spread_{};
  std::minstd_rand random_;
  bool ack_wanted_ = false;
  std::size_t unacked_bytes_ = 0;
  std::size_t unacked_ = 0;
};

template <class Accepts>
core::SampleHandle ArrivalWindow::next(core::EndpointId reader, const Accepts& accepts) {
  const auto cursor = std::ranges::find(readers_, reader, &Reader::id);
  if (cursor == readers_.end()) return {};
  Place& place = cursor->place;
  place = std::max(place, slots_.begin());
  while (slots_.contains(place)) {
    const Slot& slot = slots_[place];
    if (slot.state == State::missing) return {};
    cursor->turn();
    const bool is_for_it = slot.sample && accepts(*slot.sample, cursor->request);
    if (slot.state == State::begun && is_for_it) return {};
    ++place;
    if (is_for_it) return slot.sample;
  }
  return {};
}

template <class CameAt>
std::vector<ArrivalWindow::Gap> ArrivalWindow::due_gaps(Time now, const CameAt& came_at,
                                                        std::size_t gaps_max) {
  std::vector<Gap> gaps;
  std::size_t awaited = 0;  // asked for, and it is too early to ask again
  look_at_ = Time::max();
  looked_at_ = now;
  if (now - heard_at_ > limits_.forget_after) return gaps;
  const Place end = slots_.end();
  const bool head_has_begun = next_ < end && slots_[next_].state == State::begun;
  const bool stuck = is_stuck(head_has_begun ? came_at(slots_[next_].label) : Time{}, now);
  for (Place place = next_; place < end; ++place) {
    Slot& slot = slots_[place];
    if (slot.state == State::whole || slot.state == State::passed) continue;
    Time came = slot.state == State::begun ? came_at(slot.label) : Time{};
    if (stuck && slot.state == State::begun && now - came >= limits_.claim_patience) {
      give_back(slot, now);
      came = Time{};
    }
    if (came > slot.asked_at) slot.asked = 0;
    Time due = slot.state == State::begun ? std::max(slot.ask_at, came + delay_ + slot.apart) : slot.ask_at;
    if (due > now) {
      awaited += slot.asked > 0 ? 1 : 0;
    } else if (gaps.size() + awaited >= gaps_max) {
      due = now + delay_;
    } else {
      gaps.push_back({ordinal_of(place), place, {}});
      if (slot.state == State::begun) gaps.back().label = slot.label;
      const auto pause = delay_ * (2 << std::min<int>(slot.asked, 8));
      due = slot.ask_at = now + std::min<Time::duration>(pause, limits_.ask_again_longest);
      slot.asked_at = now;
      slot.parts = 1;
      if (slot.asked < UINT8_MAX) ++slot.asked;
    }
    look_at(due);
  }
  return gaps;
}

}  // namespace sft::udp
