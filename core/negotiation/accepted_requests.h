// Keeps the requests of a reader for which samples may still come. A reliable reader gets samples however
// late they come. So for such a reader a request ends with a certain sample in order (Accepted::request),
// and not after a certain time. Pure: calls and times are passed in, decisions are returned.
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
  /// The longest time for which datagrams may be in flight. After this time all writers have received a new
  /// request.
  static constexpr std::chrono::seconds in_flight_max{2};
  /// The maximum number of requests that are kept. If there are more, the oldest ones are dropped.
  static constexpr std::size_t best_effort_max = 16, reliable_max = 64;

  AcceptedRequests() = default;
  AcceptedRequests(Wanted first, bool reliable);

  /// Called when the reader makes another request. An earlier request is dropped once no sample that was
  /// sent for it can be under way any more.
  void asks_for(Wanted wanted, Time now);
  /// Drops requests, or sets Accepted::heard, when this is due. Returns true if all() has changed.
  bool look(Time now);

  const Wanted& latest() const { return requests_.back().accepted.wanted; }
  /// Returns all requests; the latest is the last.
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
