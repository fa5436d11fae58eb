// The parts of samples that are asked for once more, the oldest first, at a limited rate. Pure.
//
// A part waits at most once, however often it is asked for, and is not sent again while it may still be on
// its way.
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

  static constexpr std::size_t repairs_max = 512;  ///< that wait; others have to be asked for again

  explicit RepairQueue(std::uint64_t bytes_per_s);

  struct Repair {
    std::uint64_t ordinal = 0;
    BodyRange range;
  };
  void ask_for(const Repair& repair);
  /// Forgets what was sent at that time or earlier: it has arrived by now.
  void forget_sent_before(Time time);
  /// The samples before that ordinal are not kept any more.
  void drop_before(std::uint64_t ordinal);
  /// Takes the next part of that size, if the rate allows one now.
  std::optional<Repair> next(Size size, Time now);

  bool empty() const { return waiting_.empty(); }
  /// The time at which next() allows a repair; Time::max() if the last call gave one, or nothing waits.
  Time next_ready(Time now) const { return is_paced_ ? pacer_.next_ready(now) : Time::max(); }
  std::uint64_t sent() const { return sent_; }  ///< parts in all

 private:
  struct Sent {
    Repair repair;
    Time at{};
  };

  std::vector<Repair> waiting_;   ///< the oldest first
  std::deque<Sent> sent_lately_;  ///< the oldest first
  Pacer pacer_;
  bool is_paced_ = false;  ///< the last next() had to leave one for later
  std::uint64_t sent_ = 0;
};

}  // namespace sft::udp
