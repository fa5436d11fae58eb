// Runs all contenders at the same time, each on a network of its own, with the same messages in the same
// phases.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "bench/common/host_processes.h"
#include "bench/paper/record.h"
#include "bench/paper/team.h"

namespace sft::bench::paper {

/// A network for each contender and for each idle twin: a sender's host and `receivers_max` further hosts.
class Stage {
 public:
  explicit Stage(std::vector<Contender> contenders);

  const std::vector<Contender>& contenders() const { return contenders_; }
  /// Returns the contenders of the idle teams, which write nothing, in the order of the first contender of
  /// each.
  const std::vector<Contender>& idle_twins() const { return idle_twins_; }
  /// Returns a network. The networks of the contenders come first, followed by those of the twins.
  std::shared_ptr<const hosts::EmulatedNetwork> network(std::size_t number) const {
    return networks_[number];
  }

 private:
  const std::vector<Contender> contenders_;
  std::vector<Contender> idle_twins_;
  std::vector<std::shared_ptr<const hosts::EmulatedNetwork>> networks_;
};

struct Results {
  std::vector<Record> records;
  std::vector<double> late_us;        ///< delay of each message relative to its planned time
  std::size_t repeated_sessions = 0;  ///< sessions that were repeated because of disturbed records
};

/// Runs a session, and adds its records to `results`. `seed` determines the slots of the contenders.
/// Contenders that are not ready in time are named on the standard error, and have no records. Idle traffic
/// comes in bursts a few seconds apart. So it is counted in the same seconds, on the network of the
/// contender's twin. A session most of whose records are disturbed is repeated once.
void run_session(const Stage& stage, std::size_t receivers, const std::vector<Phase>& phases,
                 const Pace& pace, std::uint64_t seed, Results& results);

}  // namespace sft::bench::paper
