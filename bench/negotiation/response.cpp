// Measures the time from the getter that meets an absent field until the publisher on another host has
// applied the new mask.
#include <sft/sft.h>
#include <sensor_msgs/msg/PointCloud2.hpp>

#include "bench/common/hosts.h"
#include "bench/common/node_options.h"
#include "bench/common/statistics.h"
#include "bench/negotiation/negotiation.h"
#include "bench/negotiation/raw_cyclone.h"

namespace sft::bench {

namespace {

using sensor_msgs::msg::PointCloud2;
using F = PointCloud2::Field;

constexpr std::int64_t patience_ns = 1'000'000'000;

/// Publishes a thousand times a second, and records when a reader asks for `height`.
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
  Node node = Node::open(udp_node_options("publisher")).value();
  auto publisher = node.publisher<PointCloud2>("points", {.on_readers_changed = note}).value();
  const PointCloud2 message;
  while (exchange.received.load() < messages && !exchange.failed.load()) {
    sleep_us(1000);
    publisher.publish(message);
  }
}

/// Whenever the subscriber has given up `height` and gets samples without it, reads `height` until the node
/// asks for it.
void subscribe(Exchange& exchange, std::uint64_t messages) {
  const FieldMask wanted = FieldMask(F::height);
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
    if (exchange.sent.load() > n) {  // the request has arrived
      (void)sample->height();        // on a busy machine, the field might be given up again before
      exchange.failed = now_ns() > exchange.sent_at[n] + patience_ns;
    } else if (n < messages && !sample.mask().contains(wanted) &&
               !subscriber.status().mask.contains(wanted)) {
      exchange.sent_at[n] = now_ns();
      exchange.sent = n + 1;
      (void)sample->height();
    }
  }
}

/// The reference: Cyclone DDS alone, from a thread of one program to a thread of another one, with the QoS of
/// requests.
void write(Exchange& exchange, std::uint64_t messages) {
  RawCyclone cyclone;
  const dds_entity_t writer = cyclone.writer("requests", RawCyclone::Delivery::last_value);
  while (!exchange.ready.load() || RawCyclone::readers(writer) == 0) sleep_us(1000);
  for (std::uint64_t i = 0; i < messages; ++i) {
    sleep_us(1000);
    exchange.sent_at[i] = now_ns();
    RawCyclone::write(writer, i + 1);
  }
}

void listen(Exchange& exchange, std::uint64_t messages) {
  const RawCyclone::Arrived note = [&](std::uint64_t number) {
    exchange.received_at[number - 1] = now_ns();
    exchange.received.store(number, std::memory_order_release);
  };
  RawCyclone cyclone;
  cyclone.reader("requests", RawCyclone::Delivery::last_value, note);
  exchange.ready = true;
  while (exchange.received.load() < messages && !exchange.failed.load()) sleep_us(1000);
}

}  // namespace

std::vector<Figure> str_response(const Scale& scale) {
  const TwoHosts hosts;
  const std::uint64_t n = scale.messages;
  Rounds ours, raw;
  for (int round = 0; round < scale.rounds; ++round) {
    ours.add(
        run_pair(hosts.sides([=](Exchange& e) { publish(e, n); }, [=](Exchange& e) { subscribe(e, n); }), n));
    raw.add(run_pair(hosts.sides([=](Exchange& e) { write(e, n); }, [=](Exchange& e) { listen(e, n); }), n));
  }
  const char* reference = "dds_write to a listener";
  return {{"str_response", ours.p50(), "us", raw.p50(), reference, 100, true},
          {"str_response_p99", ours.p99(), "us", raw.p99(), reference, 1000, true}};
}

}  // namespace sft::bench
