// The plan of a run. A seed determines the plan before the run begins.
#pragma once

#include <cstddef>
#include <cstdint>

#include "tests/simulation/udp/network.h"
#include "tests/simulation/udp/random.h"
#include "tests/simulation/udp/topic.h"
#include "udp_transport/receive/reassembly.h"
#include "udp_transport/reliable/resend_window.h"

namespace sft::simulation {

/// The wishes of the readers, and how often they change.
struct Asking {
  std::size_t wishes = masks_end;  ///< the number of wishes() that are used, counted from the first
  double change = 0;               ///< the probability that a reader changes its wish
  /// The probability of a change of a wish at any event, while parts of a sample are under way, lost or
  /// repaired.
  double change_midway = 0;
  double churn = 0;       ///< the probability that a reader joins or leaves
  std::size_t quiet = 0;  ///< the number of samples at the end without such changes
};

/// The kinds of runs.
enum class Plan : std::uint8_t {
  usual,
  beset,     ///< at the beginning, datagrams are also forged
  churning,  ///< readers join, leave and change their conditions with nearly each sample
};

/// The plan of a run. Probabilities are those of an event after each published sample.
struct Scenario {
  bool forgers;
  Weather weather;
  std::size_t datagram_bytes = 1472;
  std::size_t samples = 40;
  std::size_t sample_bytes_max = 20'000;
  std::uint64_t first_sequence = 1;
  std::uint64_t first_ordinal = 1;
  bool tight_writer = false;  ///< whether the writer holds few samples
  bool tight_reader = false;
  bool crashes = false;  ///< whether the process of the readers crashes and is started again
  Asking asking{};
  std::size_t receive_buffer_bytes = 212'992;
  double regroup = 0;        ///< the probability that the multicast group of the process changes
  double span = 0;           ///< the probability that several samples are published at once
  bool readers_lag = false;  ///< whether readers take few samples at a time, and the writer waits for them
  double detour = 0;  ///< the probability that datagrams change to another path, with another limit of length
  /// The time during which the writer sends only heartbeats.
  Time stalled_from = Time::max(), stalled_until{};
  udp::ResendLimits resend{};
  udp::ReassemblyLimits reassembly{};

  Scenario(Random& random, Plan plan);

 private:
  void beset(Random& random);
  void churn();
};

/// Returns the longest length of datagrams on a random path.
std::size_t any_datagram_bytes(Random& random);

}  // namespace sft::simulation
