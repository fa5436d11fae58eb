// The parts of samples that receivers have requested again (repairs), in the order of requests. They are
// sent at a limited rate. Uses no clock, thread or I/O.
//
// A part waits at most once, however often it is requested. It is not sent again while an earlier copy may
// still be under way.
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

  /// The maximum number of waiting repairs; further ones are dropped and have to be requested again.
  static constexpr std::size_t repairs_max = 512;

  explicit RepairQueue(std::uint64_t bytes_per_s);

  struct Repair {
    std::uint64_t ordinal = 0;
    BodyRange range;
  };
  void ask_for(const Repair& repair);
  /// Discards the records of repairs that were sent at that time or earlier. Called when these repairs must
  /// have arrived.
  void forget_sent_before(Time time);
  /// Drops the repairs of samples with lower ordinals. Called when these samples are not kept any more.
  void drop_before(std::uint64_t ordinal);
  /// Takes the oldest waiting repair whose length is in that size class, if the rate limit allows a repair
  /// now.
  std::optional<Repair> next(Size size, Time now);

  bool empty() const { return waiting_.empty(); }
  /// Returns the time at which next() will return a repair; Time::max() if the last call of next() was not
  /// held up by the rate limit.
  Time next_ready(Time now) const { return is_paced_ ? pacer_.next_ready(now) : Time::max(); }
  std::uint64_t sent() const { return sent_; }  ///< number of repairs taken so far

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
