// The plan of a run, which a seed decides before the run begins.
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
  std::size_t wishes = masks_end;  ///< how many of wishes() are used, counted from the first
  double change = 0;               ///< probability that a reader asks for something else
  /// Probability of such a change at any event, while parts of a sample are under way, lost or repaired.
  double change_midway = 0;
  double churn = 0;       ///< probability that a reader joins or leaves
  std::size_t quiet = 0;  ///< number of samples at the end without such changes
};

/// The kinds of runs.
enum class Plan : std::uint8_t {
  usual,
  beset,     ///< at the beginning datagrams are forged, too
  churning,  ///< readers join, leave and change their conditions with nearly each sample
};

/// The plan. Probabilities are those of an event after each published sample.
struct Scenario {
  bool forgers;
  Weather weather;
  std::size_t datagram_bytes = 1472;
  std::size_t samples = 40;
  std::size_t sample_bytes_max = 20'000;
  std::uint64_t first_sequence = 1;
  std::uint64_t first_ordinal = 1;
  bool tight_writer = false;  ///< the writer keeps few samples
  bool tight_reader = false;
  bool crashes = false;  ///< the process of the readers crashes and is started again
  Asking asking{};
  std::size_t receive_buffer_bytes = 212'992;
  double regroup = 0;        ///< probability that the multicast group of the process changes
  double span = 0;           ///< probability that several samples are published instead of one
  bool readers_lag = false;  ///< readers take a few samples now and then, and the writer waits for them
  double detour = 0;         ///< probability that datagrams take another path, with another limit of length
  Time stalled_from = Time::max(), stalled_until{};  ///< span in which the writer sends only heartbeats
  udp::ResendLimits resend{};
  udp::ReassemblyLimits reassembly{};

  Scenario(Random& random, Plan plan);

 private:
  void beset(Random& random);
  void churn();
};

/// Returns the limit of the length of datagrams on a random path.
std::size_t any_datagram_bytes(Random& random);

}  // namespace sft::simulation
