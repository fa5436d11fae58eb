// Measures the time from a getter call for an absent field until the publisher on another host has applied
// the new mask, for messages of any type. `Probe` has the type Message, the field `wanted`, and the
// functions read_usual() and read_wanted(). read_wanted() reads the field `wanted` of a sample, and
// read_usual() reads another field.
#pragma once

#include <sft/sft.h>

#include <cstdint>
#include <vector>

#include "bench/common/contender.h"
#include "bench/common/hosts.h"
#include "bench/common/node_options.h"

namespace sft::bench {

/// Publishes a thousand times per second, and notes when a reader requests the wanted field.
template <class Probe>
void publish_to_learner(Exchange& exchange, std::uint64_t messages) {
  const FieldMask wanted = FieldMask(Probe::wanted);
  const auto note = [&](const PublisherStatus& status) {
    const std::uint64_t n = exchange.sent.load();
    const bool asked = !status.readers.empty() && status.readers[0].mask.contains(wanted) &&
                       !status.readers[0].mask.is_full();
    if (!asked || n == 0 || exchange.received.load() >= n) return;
    exchange.received_at[n - 1] = now_ns();
    exchange.received = n;
  };
  Node node = Node::open(udp_node_options("publisher")).value();
  auto publisher = node.publisher<typename Probe::Message>("points", {.on_readers_changed = note}).value();
  const typename Probe::Message message;
  while (exchange.received.load() < messages && !exchange.failed.load()) {
    sleep_us(1000);
    publisher.publish(message);
  }
}

/// Reads the wanted field whenever the subscriber no longer requests it and gets samples without it. Goes
/// on reading it until the publisher has noted the request.
template <class Probe>
void learn(Exchange& exchange, std::uint64_t messages) {
  constexpr std::int64_t timeout_ns = 1'000'000'000;
  const FieldMask wanted = FieldMask(Probe::wanted);
  Node node = Node::open(udp_node_options("subscriber")).value();
  auto subscriber = node.subscriber<typename Probe::Message, recorded>(
                            "points", {.recording = {.learn_samples = 2, .narrow_after_samples = 3}})
                        .value();
  while (exchange.received.load() < messages && !exchange.failed.load()) {
    exchange.failed = !subscriber.wait(std::chrono::seconds(2));
    const auto sample = subscriber.take();
    if (!sample) continue;
    Probe::read_usual(sample);
    const std::uint64_t n = exchange.received.load();
    if (exchange.sent.load() > n) {  // the publisher has not noted the request yet
      // Otherwise the subscriber of a busy machine might drop the field before the publisher has noted it.
      Probe::read_wanted(sample);
      exchange.failed = now_ns() > exchange.sent_at[n] + timeout_ns;
    } else if (n < messages && !sample.mask().contains(wanted) &&
               !subscriber.status().mask.contains(wanted)) {
      exchange.sent_at[n] = now_ns();
      exchange.sent = n + 1;
      Probe::read_wanted(sample);
    }
  }
}

/// Returns the response times in microseconds.
template <class Probe>
std::vector<double> response_times(const TwoHosts& hosts, std::uint64_t messages) {
  return run_pair(hosts.sides([=](Exchange& e) { publish_to_learner<Probe>(e, messages); },
                              [=](Exchange& e) { learn<Probe>(e, messages); }),
                  messages);
}

/// Returns Cyclone DDS alone, with SFT's configuration. Its samples are about as large as a request.
/// Durable topics have the QoS of requests.
std::unique_ptr<Peer> cyclone_control_peer();

/// Returns the reference: times of Cyclone DDS alone from a thread of one program to a thread of another
/// program, with the QoS of requests.
std::vector<double> dds_write_times(const TwoHosts& hosts, std::uint64_t messages);

}  // namespace sft::bench
