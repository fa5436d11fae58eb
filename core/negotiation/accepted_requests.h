// This class knows under which of its requests samples for a reader may still arrive. A reliable reader gets
// what was sent however late. For such a reader no time tells when a request is over, but the order of the
// samples does (Accepted::request).
//
// The class is pure: calls and times go in, answers come out.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/platform/clock.h"
#include "core/seam/transport.h"

namespace sft::core {

class AcceptedRequests {
 public:
  /// For so long datagrams may be in flight, and what a reader asks for is not known to all who send to it.
  static constexpr std::chrono::seconds in_flight_max{2};
  /// If there are more requests, the oldest ones are forgotten.
  static constexpr std::size_t best_effort_max = 16, reliable_max = 64;

  AcceptedRequests() = default;
  AcceptedRequests(Wanted first, bool reliable);

  /// From now on that, and no longer what was asked for before, once nothing of it can be under way any more.
  void asks_for(Wanted wanted, Time now);
  /// Whether all() has changed with time.
  bool look(Time now);

  const Wanted& latest() const { return requests_.back().accepted.wanted; }
  /// The latest is the last.
  std::vector<Accepted> all() const;

 private:
  struct Request {
    Accepted accepted;
    Time asked_at{};
    Time replaced_at = Time::max();
  };
  bool reliable_ = false;
  std::uint64_t last_ = 0;
  std::vector<Request> requests_;
};

}  // namespace sft::core
