#include "tests/simulation/udp/scenario.h"

#include <algorithm>
#include <chrono>

namespace sft::simulation {

using namespace std::chrono_literals;

std::size_t any_datagram_bytes(Random& random) {
  constexpr std::size_t lengths[] = {548, 1472, 8972};
  return lengths[from_to(random, 0, 2)];
}

Scenario::Scenario(Random& random, Plan plan) : forgers(plan == Plan::beset) {
  weather.loss = happens(random, 0.2) ? 0 : std::uniform_real_distribution<>(0, 0.3)(random);
  weather.repetition = happens(random, 0.5) ? 0 : 0.1;
  weather.delay = std::chrono::microseconds(log_uniform(random, 20'000));
  weather.jitter = std::chrono::microseconds(log_uniform(random, 30'000));
  if (happens(random, 0.3)) {
    weather.parted_from = start_time + std::chrono::milliseconds(from_to(random, 0, 100));
    weather.parted_until = weather.parted_from + std::chrono::milliseconds(log_uniform(random, 10'000));
  }
  datagram_bytes = any_datagram_bytes(random);
  sample_bytes_max = datagram_bytes > 5000 && happens(random, 0.5) ? 200'000 : 12'000;
  if (happens(random, 0.3)) first_sequence = 0xffff'ffff - from_to(random, 0, 30);
  if (happens(random, 0.2)) first_ordinal = 0xffff'ffff - from_to(random, 0, 30);
  if (happens(random, 0.1)) first_ordinal = udp::ordinal_max - from_to(random, 2000, 2030);
  tight_writer = happens(random, 0.2);
  tight_reader = happens(random, 0.2);
  crashes = happens(random, 0.15);
  asking.change = happens(random, 0.5) ? 0.1 : 0;
  regroup = happens(random, 0.5) ? 0.15 : 0;
  span = happens(random, 0.3) ? 0.2 : 0;
  readers_lag = happens(random, 0.3);
  detour = happens(random, 0.3) ? 0.2 : 0;
  if (happens(random, 0.2)) {
    stalled_from = start_time + std::chrono::milliseconds(from_to(random, 0, 100));
    stalled_until = stalled_from + std::chrono::milliseconds(log_uniform(random, 10'000));
  }
  if (forgers) beset(random);
  resend.repair_bytes_per_s = 20'000'000;
  reassembly.channel.ack_bytes = from_to(random, 5'000, 125'000);
  receive_buffer_bytes += log_uniform(random, 8e6);
  if (tight_writer) {
    resend.samples = from_to(random, 2, 12);
    resend.bytes = from_to(random, 20'000, 200'000);
  }
  if (happens(random, 0.6)) asking.wishes = usual_wishes_end;
  if (asking.change != 0 && happens(random, 0.5)) asking.change_midway = 0.005;
  if (plan == Plan::churning) churn();
  if (!tight_reader) return;
  reassembly.channel.samples = from_to(random, 4, 16);
  reassembly.channel.held_bytes = from_to(random, 20'000, 200'000);
  reassembly.channel.awaited_bytes = 2 * reassembly.channel.held_bytes;
}

/// Plans forgeries. Removes all other reasons for which samples may be missing, and makes the run long
/// enough.
void Scenario::beset(Random& random) {
  weather.forged = std::uniform_real_distribution<>(0.01, 0.5)(random);
  weather.forged_until = start_time + 200ms;
  weather.loss = std::min(weather.loss, 0.1);
  weather.parted_until = {};
  stalled_from = Time::max();
  first_ordinal = 1;
  asking.change = 0;
  tight_writer = tight_reader = crashes = readers_lag = false;
  sample_bytes_max = std::min<std::size_t>(sample_bytes_max, 12'000);
  samples = 1300;  // enough samples even if conditions pass only every third one
}

/// Plans many changes of readers. Samples are missing only because of loss. The delays are short: each sample
/// arrives before its reader has made so many further requests that the sample's request is discarded.
void Scenario::churn() {
  weather.loss = std::min(weather.loss, 0.1);
  weather.delay = std::min(weather.delay, std::chrono::microseconds(3000));
  weather.jitter = std::min(weather.jitter, std::chrono::microseconds(5000));
  weather.parted_until = {};
  stalled_from = Time::max();
  // an ordinal far from the last one of a channel
  first_ordinal = std::min<std::uint64_t>(first_ordinal, UINT32_MAX);
  tight_writer = tight_reader = crashes = readers_lag = false;
  resend = {.repair_bytes_per_s = resend.repair_bytes_per_s};
  reassembly = {};
  samples = 5000;
  sample_bytes_max = std::min<std::size_t>(sample_bytes_max, 3000);
  regroup = 0.15;
  asking = {.wishes = simulation::wishes().size(),
            .change = 0.25,
            .change_midway = 0.002,
            .churn = 0.5,
            .quiet = 200};
}

}  // namespace sft::simulation
