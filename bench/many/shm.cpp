// Measures shared memory: publish(message) to a reader that sleeps, and the best time for wait() to spin.
#include <algorithm>
#include <array>
#include <optional>

#include "bench/common/statistics.h"
#include "bench/common/transfer.h"
#include "bench/many/many.h"
#include "bench/many/tally.h"

namespace sft::bench {

namespace {

using std::chrono::microseconds;

constexpr std::int64_t period_us = 5000;  // a rate of 200 Hz

/// Sends samples. The writer sleeps between them, like the reader.
void send_slowly(Exchange& exchange, const Topic& topic, std::uint64_t messages) {
  const auto peer = sft_memory_peer();
  const auto writer = peer->writer(topic);
  exchange.failed = !wait_until([&] { return exchange.ready.load() && writer->serves(1); });
  for (std::uint64_t i = 0; i < messages && !exchange.failed; ++i) {
    sleep_us(period_us);
    exchange.sent_at[i] = now_ns();
    writer->write(i + 1);
  }
  exchange.failed = exchange.failed || !exchange.wait_for_receipt(messages);
}

/// Returns the median time until wait() has returned and the sample is taken.
double wait_us(std::optional<microseconds> spin, std::uint64_t messages) {
  const Topic topic{.reliable = false, .spin = spin};
  return median_if_any(run_pair({.sender = [&](Exchange& e) { send_slowly(e, topic, messages); },
                                 .receiver =
                                     [&](Exchange& e) {
                                       const auto peer = sft_memory_peer();
                                       receive_each(e, {.messages = messages}, *peer->reader(topic));
                                     }},
                                messages));
}

}  // namespace

std::vector<Figure> shm_publish(const ManyScale& scale) {
  const Transfer transfer{.messages = scale.quick ? 400u : 1600u, .preparing_counts = true};
  const Topic numbered{.reliable = false};
  const Topic of_64_bytes{.bulk_bytes = 64, .reliable = false};
  const Topic of_16_kb{.bulk_bytes = 16'000, .reliable = false};
  Tally small, medium;
  for (int round = 0; round < scale.rounds; ++round) {
    small.add_ours(median_if_any(transfer_times(sft_memory_peer, numbered, transfer)));
    small.add_reference(median_if_any(transfer_times(iceoryx_loan_peer, of_64_bytes, transfer)));
    medium.add_ours(median_if_any(transfer_times(sft_cloud_peer, of_16_kb, transfer)));
    medium.add_reference(median_if_any(transfer_times(iceoryx_loan_peer, of_16_kb, transfer)));
  }
  return {small.figure("shm_publish_64B", "us", "iceoryx WaitSet", 1.2),
          medium.figure("shm_publish_16kB", "us", "iceoryx WaitSet", 1.2)};
}

/// Compares values of `spin`. The noise is the largest difference between two rounds with the default.
std::vector<Figure> shm_wait(const ManyScale& scale) {
  constexpr std::array spins{microseconds(0), microseconds(5), microseconds(50), microseconds(200)};
  const std::uint64_t messages = scale.quick ? 60 : 400;
  // At least two, since the noise cannot be estimated from one round.
  const int rounds = std::max(scale.rounds, 2);
  std::vector<double> usual;
  std::array<std::vector<double>, spins.size()> fixed;
  for (int round = 0; round < rounds; ++round) {
    usual.push_back(wait_us({}, messages));
    for (std::size_t i = 0; i < spins.size(); ++i) fixed[i].push_back(wait_us(spins[i], messages));
  }
  std::size_t best = 0;
  for (std::size_t i = 1; i < spins.size(); ++i) {
    if (median(fixed[i]) < median(fixed[best])) best = i;
  }
  const auto [least, most] = std::ranges::minmax(usual);
  const std::string of = "spinning for " + std::to_string(spins[best].count()) + " us, the best";
  return {{.name = "shm_wait_200Hz",
           .value = median(usual),
           .unit = "us",
           .reference = median(fixed[best]),
           .reference_name = of,
           .bound = 1,
           .worst = most},
          {"shm_wait_200Hz_noise", most - least, "us", {}, "between rounds of the default"}};
}

}  // namespace sft::bench
