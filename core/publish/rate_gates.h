// The gates of one writer: one for each limit that its readers ask for, shared by all that ask for it.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>

#include "core/seam/rate_gate.h"
#include "core/seam/transport.h"

namespace sft::core {

/// Used by the agent's thread. The gates themselves are used by the publisher's thread.
class RateGates {
 public:
  /// Before routes are given theirs: lets go of gates that nobody has used for long, beyond a few. Until then
  /// they are kept: their numbers go on when somebody asks for the limit again.
  void tidy();
  /// Gives each route the gate of its limit, or none.
  void give(std::span<Route> routes);
  /// The gate that give() gave to the route.
  const std::shared_ptr<RateGate>& of(const Route& route) const { return gates_.at(route.min_period_us); }

 private:
  std::map<std::uint32_t, std::shared_ptr<RateGate>> gates_;  ///< by period
};

}  // namespace sft::core
