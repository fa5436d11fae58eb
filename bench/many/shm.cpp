// Measures shared memory: publish(message) to a reader that sleeps, and how long wait() should spin.
#include <sft/sft.h>
#include <algorithm>
#include <array>
#include <messages.hpp>
#include <optional>

#include "bench/common/node_options.h"
#include "bench/common/raw_iceoryx.h"
#include "bench/common/sft_cloud.h"
#include "bench/common/statistics.h"
#include "bench/common/transfer.h"
#include "bench/many/many.h"
#include "bench/many/tally.h"

namespace sft::bench {

namespace {

using sft_bench::Small;
using std::chrono::microseconds;

constexpr std::uint32_t small_bytes = 64;
constexpr std::uint32_t medium_bytes = 16'000;
constexpr std::int64_t period_us = 5000;  // 200 Hz

Node open(const char* name) { return Node::open(node_options(name, TransportChoice::shm)).value(); }

class SmallWriter {
 public:
  bool serves(std::size_t readers) const {
    return publisher_.wait_for_subscribers(readers, std::chrono::nanoseconds(0));
  }
  void prepare(std::uint64_t number) { message_.number = number; }
  void publish() { publisher_.publish(message_); }

 private:
  Node node_ = open("writer");
  Publisher<Small> publisher_ = node_.publisher<Small>("small").value();
  Small message_{};
};

class SmallReader {
 public:
  explicit SmallReader(const SubscriberOptions& options = {})
      : subscriber_(node_.subscriber<Small>("small", options).value()) {}

  void wait() { subscriber_.wait(std::chrono::seconds(1)); }
  std::uint64_t take() {
    const auto sample = subscriber_.take();
    return sample ? sample->number() : 0;
  }
  std::size_t writers() const {
    const std::vector<SubscriberStatus::Writer> writers = subscriber_.status().writers;
    return static_cast<std::size_t>(std::ranges::count_if(writers, &SubscriberStatus::Writer::connected));
  }

 private:
  Node node_ = open("reader");
  Subscriber<Small> subscriber_;
};

/// The writer sleeps, too.
void send_slowly(Exchange& exchange, std::uint64_t messages) {
  SmallWriter writer;
  exchange.failed = !wait_until([&] { return exchange.ready.load() && writer.serves(1); });
  for (std::uint64_t i = 0; i < messages && !exchange.failed; ++i) {
    sleep_us(period_us);
    writer.prepare(i + 1);
    exchange.sent_at[i] = now_ns();
    writer.publish();
  }
  exchange.failed = exchange.failed || !exchange.wait_for_receipt(messages);
}

/// The median time until wait() has returned and the sample is taken.
double wait_us(std::optional<microseconds> spin, std::uint64_t messages) {
  SubscriberOptions options;
  if (spin) options.spin = *spin;
  return median_if_any(run_pair({.sender = [&](Exchange& e) { send_slowly(e, messages); },
                                 .receiver =
                                     [&](Exchange& e) {
                                       SmallReader reader(options);
                                       receive_each(e, {.messages = messages}, reader);
                                     }},
                                messages));
}

}  // namespace

std::vector<Figure> shm_publish(const ManyScale& scale) {
  const Transfer transfer{.messages = scale.quick ? 400u : 1600u, .preparing_counts = true};
  Tally small, medium;
  for (int round = 0; round < scale.rounds; ++round) {
    small.add_ours(median_if_any(transfer_times<SmallWriter, SmallReader>(transfer)));
    small.add_reference(
        median_if_any(transfer_times<RawIceoryxWriter, RawIceoryxReader>(transfer, small_bytes)));
    medium.add_ours(median_if_any(transfer_times<SftOwnedWriter, SftReader>(transfer, medium_bytes)));
    medium.add_reference(
        median_if_any(transfer_times<RawIceoryxWriter, RawIceoryxReader>(transfer, medium_bytes)));
  }
  return {small.figure("shm_publish_64B", "us", "iceoryx WaitSet", 1.2),
          medium.figure("shm_publish_16kB", "us", "iceoryx WaitSet", 1.2)};
}

/// The noise is the largest difference between two rounds of the default.
std::vector<Figure> shm_wait(const ManyScale& scale) {
  constexpr std::array spins{microseconds(0), microseconds(5), microseconds(50), microseconds(200)};
  const std::uint64_t messages = scale.quick ? 60 : 400;
  const int rounds = std::max(scale.rounds, 2);  // one round has no noise to tell
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
