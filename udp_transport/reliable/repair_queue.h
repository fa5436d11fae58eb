// The parts of samples that receivers request again, the oldest first, at a limited rate. Uses no clock,
// thread or I/O.
//
// A part waits at most once, however often it is requested, and is not sent again while it may still be
// under way.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "udp_transport/flow/pacer.h"
#include "udp_transport/reliable/kept_samples.h"
#include "udp_transport/wire/fragmenter.h"

namespace sft::udp {

class RepairQueue {
 public:
  using Time = std::chrono::steady_clock::time_point;
  using Size = KeptSamples::Size;

  /// The number of repairs that may wait. Further ones have to be requested again.
  static constexpr std::size_t repairs_max = 512;

  explicit RepairQueue(std::uint64_t bytes_per_s);

  struct Repair {
    std::uint64_t ordinal = 0;
    BodyRange range;
  };
  void ask_for(const Repair& repair);
  /// Discards the records of repairs that were sent at that time or earlier, because these have arrived by
  /// now.
  void forget_sent_before(Time time);
  /// Drops the repairs of samples before that ordinal, because these samples are not kept any more.
  void drop_before(std::uint64_t ordinal);
  /// Takes the oldest waiting part whose length is in that class, if the rate allows a repair now.
  std::optional<Repair> next(Size size, Time now);

  bool empty() const { return waiting_.empty(); }
  /// Returns when next() allows a repair; Time::max() if the last call returned one, or if none waited.
  Time next_ready(Time now) const { return is_paced_ ? pacer_.next_ready(now) : Time::max(); }
  std::uint64_t sent() const { return sent_; }  ///< number of parts sent so far

 private:
  struct Sent {
    Repair repair;
    Time at{};
  };

  std::vector<Repair> waiting_;   ///< repairs that wait; the oldest is first
  std::deque<Sent> sent_lately_;  ///< repairs under way; the oldest is first
  Pacer pacer_;
  bool is_paced_ = false;  ///< true if the last call of next() had to postpone a repair
  std::uint64_t sent_ = 0;
};

}  // namespace sft::udp
