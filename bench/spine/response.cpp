// How long it takes from a getter that meets an absent field to the publisher having changed what it sends.
#include <sft/sft.h>
#include <sensor_msgs/msg/PointCloud2.hpp>

#include "bench/common/statistics.h"
#include "bench/spine/hosts.h"
#include "bench/spine/spine.h"

namespace sft::bench {

namespace {

using sensor_msgs::msg::PointCloud2;
using F = PointCloud2::Field;

NodeOptions options(const char* name) { return {.name = name, .transport = TransportChoice::udp}; }

/// Publishes a thousand times a second and notes when `height` is asked for.
void publish(Exchange& exchange, std::uint64_t messages) {
  const FieldMask wanted = FieldMask(F::height);
  const auto note = [&](const PublisherStatus& status) {
    const std::uint64_t n = exchange.sent.load();
    const bool asked = !status.readers.empty() && status.readers[0].mask.contains(wanted) &&
                       !status.readers[0].mask.is_full();
    if (!asked || n == 0 || exchange.received.load() >= n) return;
    exchange.received_at[n - 1] = now_ns();
    exchange.received = n;
  };
  Node node = Node::open(options("publisher")).value();
  auto publisher = node.publisher<PointCloud2>("points", {.on_readers_changed = note}).value();
  const PointCloud2 message;
  while (exchange.received.load() < messages && !exchange.failed.load()) {
    timespec millisecond{0, 1'000'000};
    nanosleep(&millisecond, nullptr);
    publisher.publish(message);
  }
}

/// Reads `height` whenever the publisher has given it up.
void subscribe(Exchange& exchange, std::uint64_t messages) {
  Node node = Node::open(options("subscriber")).value();
  auto subscriber = node.subscriber<PointCloud2, recorded>(
                            "points", {.recording = {.learn_samples = 2, .narrow_after_samples = 3}})
                        .value();
  while (exchange.received.load() < messages) {
    if (!subscriber.wait(std::chrono::seconds(2))) {
      exchange.failed = true;
      return;
    }
    const auto sample = subscriber.take();
    if (!sample) continue;
    (void)sample->width();
    const std::uint64_t n = exchange.received.load();
    if (sample.mask().contains(FieldMask(F::height)) || exchange.sent.load() > n) continue;
    exchange.sent_at[n] = now_ns();
    exchange.sent = n + 1;
    (void)sample->height();
  }
}

}  // namespace

std::vector<Figure> str_response(const Scale& scale) {
  const TwoHosts hosts;
  const std::uint64_t messages = scale.messages / 10;
  std::vector<double> p50, p99;
  for (int round = 0; round < scale.rounds; ++round) {
    auto times = run_pair(
        hosts.sides([&](Exchange& e) { publish(e, messages); }, [&](Exchange& e) { subscribe(e, messages); }),
        messages);
    p50.push_back(quantile(times, 0.5));
    p99.push_back(quantile(times, 0.99));
  }
  return {{"str_response", median(p50), "us", {}, "getter to publisher's new mask", 250},
          {"str_response_p99", median(p99), "us", {}, "", {}}};
}

}  // namespace sft::bench
