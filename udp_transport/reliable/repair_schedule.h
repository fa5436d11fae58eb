// Decides when a missing sample is requested, for the first time and again. Also decides when the window has
// to be checked for missing samples. Uses no clock, thread or I/O.
//
// The delay before a request adapts. It doubles if requested samples come twice, since then the request was
// too early. It shrinks while requested samples come once. It is never less than ArrivalLimits::ask_after.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <random>

#include "udp_transport/reliable/arrival_limits.h"

namespace sft::udp {

class RepairSchedule {
 public:
  using Time = std::chrono::steady_clock::time_point;

  static constexpr std::chrono::milliseconds delay_longest{100};

  /// A sample that is missing, or that has begun to arrive.
  struct Entry {
    std::uint8_t asked = 0;   ///< number of requests since the last part of the sample came
    std::uint32_t parts = 0;  ///< number of parts of the last request that have not come twice
    Time asked_at{};
    Time ask_at{};
    Time::duration apart{};  ///< random extra delay of requests
  };

  explicit RepairSchedule(const ArrivalLimits& limits)
      : limits_(limits), delay_(limits.ask_after), random_(limits.seed) {}

  /// Notes that a datagram of the writer came. Nothing is requested after ArrivalLimits::forget_after
  /// without such a datagram.
  void heard(Time now) { heard_at_ = now; }
  Time heard_at() const { return heard_at_; }
  bool is_forgotten(Time now) const { return now - heard_at_ > limits_.forget_after; }

  /// From now on, adds random delays to requests. Called if other processes get the same samples, and may
  /// request the same missing samples at the same time.
  void spread() { spread_ = limits_.spread; }

  /// Returns the entry of a sample that was noticed to be missing at `now`.
  Entry noticed(Time now);
  /// Notes that the sample has to come again. It is requested after the usual delay.
  void noticed_again(Entry& entry) const { entry.ask_at = heard_at_ + delay_ + entry.apart; }
  /// Returns the time at which the sample should be requested. `came` is the time when its last part came,
  /// or Time{} if no part has come.
  Time due(Entry& entry, Time came) const;
  /// Notes that the sample is requested now. Returns the time at which it should be requested again.
  Time ask(Entry& entry, Time now) const;
  /// Notes that `parts` parts of the sample were requested.
  static void asked_for(Entry& entry, std::uint32_t parts) { entry.parts = parts > 0 ? parts : 1; }
  /// Notes that a part of the sample came although it had come before. If that happens to all requested
  /// parts, the request was too early. If the network repeats datagrams, that happens to only a few parts.
  void came_again(Entry& entry);
  /// Notes that the sample is whole.
  void came_whole(const Entry& entry);
  /// Returns the time at which a part that is found missing now may be requested.
  Time soon(Time now) const { return now + delay_; }

  /// Returns true if incomplete samples make no progress although datagrams of the writer come. This is the
  /// case if the first missing sample has stayed the one at the place `next`. `first_came` is the time when
  /// its last part came.
  bool is_stuck(std::uint64_t next, Time first_came, Time now);
  /// Returns true if a sample whose last part came at `came` has to be discarded and requested anew. Called
  /// only if is_stuck() returned true or memory is short.
  bool has_timed_out(Time came, Time now) const { return now - came >= limits_.confirm_timeout; }

  /// Notes that a check for missing samples begins now.
  void begin_look(Time now) {
    look_at_ = Time::max();
    looked_at_ = now;
  }
  /// Schedules the next check at that time. If the window has many samples, checks are less frequent.
  void look_at(Time time, std::size_t samples);
  void nothing_is_missing() { look_at_ = Time::max(); }
  Time next_look() const { return look_at_; }

 private:
  const ArrivalLimits limits_;
  Time::duration delay_;
  Time::duration spread_{};
  std::minstd_rand random_;
  Time heard_at_{};
  Time look_at_ = Time::max();
  Time looked_at_{};
  std::uint64_t first_missing_ = 0;  ///< the first missing place at the last call of is_stuck()
  Time first_missing_since_{};
};

inline RepairSchedule::Entry RepairSchedule::noticed(Time now) {
  const Time::duration apart =
      spread_.count() == 0
          ? spread_
          : Time::duration(std::uniform_int_distribution<Time::rep>(0, spread_.count())(random_));
  return {.ask_at = now + delay_ + apart, .apart = apart};
}

inline RepairSchedule::Time RepairSchedule::due(Entry& entry, Time came) const {
  if (came > entry.asked_at) entry.asked = 0;
  return came == Time{} ? entry.ask_at : std::max(entry.ask_at, came + delay_ + entry.apart);
}

inline void RepairSchedule::look_at(Time time, std::size_t samples) {
  constexpr std::size_t few = 256;
  constexpr std::chrono::microseconds pause{500};
  look_at_ = std::min(look_at_, samples <= few ? time : std::max(time, looked_at_ + pause));
}

}  // namespace sft::udp
