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
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include "core/transport.h"
#include "udp_transport/datagram.h"
#include "udp_transport/ordinal_ring.h"

namespace sft::udp {

struct ArrivalLimits {
  std::size_t samples = 4096;                      ///< from the first missing one on
  std::size_t held_bytes = std::size_t{64} << 20;  ///< of whole samples behind one that is missing
  std::size_t ack_bytes = std::size_t{1} << 20;    ///< so many are acknowledged unasked
  std::chrono::milliseconds ask_after{2};          ///< something was noticed to be missing; at the least
  std::chrono::milliseconds ask_again_longest{250};
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

  /// How far a window was when nobody heard the writer any more.
  struct Mark {
    std::uint32_t channel = 0;
    std::uint64_t end = 0;  ///< ordinal behind the last one that was known of
  };
  std::optional<Mark> mark() const;
  /// A new window, of a writer that is heard again. In the same channel it begins with the first sample that
  /// it hears of, not with those that were sent meanwhile.
  void join(const Mark& left);

  /// What to do with a first datagram.
  enum class Standing : std::uint8_t {
    wanted,
    known,   ///< it, or its whole sample, has come already, or is not wanted any more
    beyond,  ///< it is of a channel of before, or there is no room for it; it will come again
  };
  struct Met {
    Standing standing{};
    Place place = 0;
  };
  Met meet(const ChannelMark& mark, Time now);

  // Of a place that was met.

  /// Its sample is being put together in that buffer, whose mask and addressee are set.
  void begun(Place place, const SampleLabel& label, core::SampleHandle buffer);
  void whole(Place place, core::SampleHandle sample);
  /// It will not come, or is for nobody here.
  void pass(Place place);
  /// What had come of it was let go of.
  void forget(Place place);
  /// Some of it came once more.
  void came_again(Place place);

  void hear(const Heartbeat& heartbeat, Time now);
  /// Samples that had begun, and will not become whole: what came of them may be let go of. Since last asked.
  std::vector<SampleLabel> take_abandoned() { return std::exchange(abandoned_, {}); }

  /// The next sample for that reader, in order; empty if there is none as yet. `accepts(buffer)` tells
  /// whether one is for it, once anything of it has come.
  template <class Accepts>
  core::SampleHandle next(core::EndpointId reader, const Accepts& accepts);
  /// Who reads from now on: those that are new begin with the first sample that has not come yet.
  void set_readers(const std::vector<core::EndpointId>& readers);
  /// Lets go of what all of them have. After next() has said for each that there is none.
  void release();

  // Asking.

  struct Gap {
    std::uint64_t ordinal = 0;
    Place place = 0;
    std::optional<SampleLabel> label{};  ///< empty: nothing of it has come
  };
  /// What has been missing for so long that it is to be asked for now. `came_at(label)` tells when something
  /// of a sample came last.
  template <class CameAt>
  std::vector<Gap> due_gaps(Time now, const CameAt& came_at, std::size_t gaps_max);

  /// Others get the same, and may miss the same at the same time: asks at times of its own from now on.
  void spread_asking() { spread_ = limits_.spread; }

  /// So many parts of it were.
  void asked_for(Place place, std::uint32_t parts);

  /// Whether something is to be acknowledged now.
  bool ack_due() const {
    return ack_wanted_ || unacked_bytes_ >= limits_.ack_bytes || unacked_ >= acked_at_once;
  }
  /// Without what is missing; counts as sent.
  Ack ack(std::uint32_t writer);
  /// When due_gaps() may find something; Time::max() if never.
  Time next_look() const { return look_at_; }

  bool knows_channel() const { return channel_.has_value(); }
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

  bool turn_to(std::uint32_t channel);
  bool reach(Place end, Time now);
  void settle(Slot& slot, State state);
  void advance();
  void give_up_oldest();
  void begin_with(Place place);
  void lose_before(Place end);
  void lose(Slot& slot);
  void look_at(Time time) { look_at_ = std::min(look_at_, time); }

  const ArrivalLimits limits_;
  std::optional<std::uint32_t> channel_;
  bool joining_ = false;  ///< nothing was heard yet since join()
  Place base_ = 0;        ///< place of ordinal 0 of the channel
  OrdinalRing<Slot> slots_{1};
  Place next_ = 1;     ///< the first that is missing or not whole
  Place end_ = 1;      ///< behind the last one that is known of
  Place skip_to_ = 1;  ///< those before are lost
  std::vector<std::pair<core::EndpointId, Place>> readers_;
  std::size_t held_bytes_ = 0;
  std::uint64_t lost_ = 0;
  std::vector<SampleLabel> abandoned_;

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
  auto cursor =
      std::find_if(readers_.begin(), readers_.end(), [&](const auto& r) { return r.first == reader; });
  if (cursor == readers_.end()) return {};
  Place& place = cursor->second;
  place = std::max(place, slots_.begin());
  while (slots_.contains(place)) {
    const Slot& slot = slots_[place];
    if (slot.state == State::missing) return {};
    const bool is_for_it = slot.sample && accepts(*slot.sample);
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
  look_at_ = Time::max();
  if (now - heard_at_ > limits_.forget_after) return gaps;
  const Place end = slots_.end();
  for (Place place = next_; place < end; ++place) {
    Slot& slot = slots_[place];
    if (slot.state == State::whole || slot.state == State::passed) continue;
    const Time came = slot.state == State::begun ? came_at(slot.label) : Time{};
    if (came > slot.asked_at) slot.asked = 0;
    Time due = slot.state == State::begun ? std::max(slot.ask_at, came + delay_ + slot.apart) : slot.ask_at;
    if (due <= now && gaps.size() < gaps_max) {
      gaps.push_back({place - base_, place, {}});
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
