#include "bench/negotiation/response.h"

#include <sft/sft.h>

#include <chrono>
#include <sensor_msgs/msg/PointCloud2.hpp>

#include "bench/common/node_options.h"
#include "bench/common/statistics.h"
#include "bench/negotiation/negotiation.h"
#include "core/discovery/dds_config.h"

namespace sft::bench {

namespace {

using sensor_msgs::msg::PointCloud2;

/// The timeout for the last messages, which usually arrive within a millisecond.
constexpr std::int64_t arriving_ns = 1'000'000'000;

const Topic requests{.name = "requests", .durable = true};

/// Publishes a thousand times per second, and notes when a reader requests the height.
void publish_to_learner(Exchange& exchange, std::uint64_t messages) {
  const FieldMask height(PointCloud2::Field::height);
  const auto note = [&](const PublisherStatus& status) {
    const std::uint64_t n = exchange.sent.load();
    const bool asked = !status.readers.empty() && status.readers[0].mask.contains(height) &&
                       !status.readers[0].mask.is_full();
    if (!asked || n == 0 || exchange.received.load() >= n) return;
    exchange.received_at[n - 1] = now_ns();
    exchange.received = n;
  };
  Node node = Node::open(udp_node_options("publisher")).value();
  auto publisher = node.publisher<PointCloud2>("points", {.on_readers_changed = note}).value();
  const PointCloud2 message;
  while (exchange.received.load() < messages && !exchange.failed.load()) {
    sleep_us(1000);
    publisher.publish(message);
  }
}

/// Reads the height whenever the subscriber no longer requests it and gets samples without it. Goes on
/// reading it until the publisher has noted the request. It reads the width of all samples.
void learn(Exchange& exchange, std::uint64_t messages) {
  constexpr std::int64_t timeout_ns = 1'000'000'000;
  const FieldMask height(PointCloud2::Field::height);
  Node node = Node::open(udp_node_options("subscriber")).value();
  auto subscriber = node.subscriber<PointCloud2, recorded>(
                            "points", {.recording = {.learn_samples = 2, .narrow_after_samples = 3}})
                        .value();
  while (exchange.received.load() < messages && !exchange.failed.load()) {
    exchange.failed = !subscriber.wait(std::chrono::seconds(2));
    const auto sample = subscriber.take();
    if (!sample) continue;
    (void)sample->width();
    const std::uint64_t n = exchange.received.load();
    if (exchange.sent.load() > n) {  // the publisher has not noted the request yet
      // Otherwise the subscriber of a busy machine might drop the field before the publisher has noted it.
      (void)sample->height();
      exchange.failed = now_ns() > exchange.sent_at[n] + timeout_ns;
    } else if (n < messages && !sample.mask().contains(height) &&
               !subscriber.status().mask.contains(height)) {
      exchange.sent_at[n] = now_ns();
      exchange.sent = n + 1;
      (void)sample->height();
    }
  }
}

void write(Exchange& exchange, std::uint64_t messages) {
  const auto peer = cyclone_control_peer();
  const auto writer = peer->writer(requests);
  while (!exchange.ready.load() || writer->readers() == 0) sleep_us(1000);
  for (std::uint64_t i = 0; i < messages; ++i) {
    sleep_us(1000);
    exchange.sent_at[i] = now_ns();
    writer->write(i + 1);
  }
  const std::int64_t end = now_ns() + arriving_ns;
  while (exchange.received.load() < messages && now_ns() < end) sleep_us(1000);
}

void listen(Exchange& exchange, std::uint64_t messages) {
  const auto peer = cyclone_control_peer();
  const auto reader = peer->reader(requests, [&](std::uint64_t number) { exchange.note_receipt(number); });
  exchange.ready = true;
  while (exchange.received.load() < messages && !exchange.failed.load()) sleep_us(1000);
}

/// Returns the reference: times of Cyclone DDS alone from a thread of one program to a listener of another
/// program, with the QoS of requests.
std::vector<double> dds_write_times(const TwoHosts& hosts, std::uint64_t messages) {
  return run_pair(
      hosts.sides([=](Exchange& e) { write(e, messages); }, [=](Exchange& e) { listen(e, messages); }),
      messages);
}

}  // namespace

std::vector<double> response_times(const TwoHosts& hosts, std::uint64_t messages) {
  return run_pair(hosts.sides([=](Exchange& e) { publish_to_learner(e, messages); },
                              [=](Exchange& e) { learn(e, messages); }),
                  messages);
}

std::unique_ptr<Peer> cyclone_control_peer() {
  return cyclone_peer_with(core::dds_config(0, {}, "").value().text);
}

std::vector<Figure> str_response(const Scale& scale) {
  const TwoHosts hosts;
  Rounds ours, raw;
  for (int round = 0; round < scale.rounds; ++round) {
    ours.add(response_times(hosts, scale.messages));
    raw.add(dds_write_times(hosts, scale.messages));
  }
  const char* reference = "dds_write to a listener";
  return {{"str_response", ours.p50(), "us", raw.p50(), reference, 100, true},
          {"str_response_ratio", ours.p50(), "us", raw.p50(), reference, 1.3},
          {"str_response_p99", ours.p99(), "us", raw.p99(), reference, 1000, true}};
}

}  // namespace sft::bench
