// Keeps the requests of a reader under which samples may still come. A reliable reader gets samples however
// late: not the time tells when a request is over, but the order of the samples (Accepted::request). Pure:
// calls and times go in, answers come out.
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
  /// For so long datagrams may be in flight, and writers may not know what a reader asks for.
  static constexpr std::chrono::seconds in_flight_max{2};
  /// If there are more requests, the oldest are forgotten.
  static constexpr std::size_t best_effort_max = 16, reliable_max = 64;

  AcceptedRequests() = default;
  AcceptedRequests(Wanted first, bool reliable);

  /// The reader asks for that from now on. An earlier request is forgotten once nothing that was sent under
  /// it can be under way any more.
  void asks_for(Wanted wanted, Time now);
  /// True if all() has changed with time.
  bool look(Time now);

  const Wanted& latest() const { return requests_.back().accepted.wanted; }
  /// All requests; the latest is the last.
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
