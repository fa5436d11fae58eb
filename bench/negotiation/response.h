// The time from the getter that meets an absent field until the publisher on another host has applied the new
// mask, for messages of any type. `Probe` has the type Message, the field `wanted`, and the functions
// read_usual() and read_wanted(), of which the latter reads that field of a sample, and the former another
// one.
#pragma once

#include <sft/sft.h>

#include <cstdint>
#include <vector>

#include "bench/common/contender.h"
#include "bench/common/hosts.h"
#include "bench/common/node_options.h"

namespace sft::bench {

/// Publishes a thousand times a second, and records when a reader asks for the wanted field.
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

/// Whenever the subscriber has given up the wanted field and gets samples without it, reads that field until
/// the node asks for it.
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
    if (exchange.sent.load() > n) {  // the request has arrived
      Probe::read_wanted(sample);    // on a busy machine, the field might be given up again before
      exchange.failed = now_ns() > exchange.sent_at[n] + timeout_ns;
    } else if (n < messages && !sample.mask().contains(wanted) &&
               !subscriber.status().mask.contains(wanted)) {
      exchange.sent_at[n] = now_ns();
      exchange.sent = n + 1;
      Probe::read_wanted(sample);
    }
  }
}

/// In microseconds.
template <class Probe>
std::vector<double> response_times(const TwoHosts& hosts, std::uint64_t messages) {
  return run_pair(hosts.sides([=](Exchange& e) { publish_to_learner<Probe>(e, messages); },
                              [=](Exchange& e) { learn<Probe>(e, messages); }),
                  messages);
}

/// Cyclone DDS alone, with SFT's configuration. Its samples have about the size of a request, and those of
/// durable topics the QoS of one.
std::unique_ptr<Peer> cyclone_control_peer();

/// The reference: Cyclone DDS alone, from a thread of one program to a thread of another one, with the QoS of
/// requests.
std::vector<double> dds_write_times(const TwoHosts& hosts, std::uint64_t messages);

}  // namespace sft::bench
