// Measures 64 bytes of fields by UDP to another host and back, from callback to callback, with readers that
// sleep.
#include <sft/sft.h>
#include <sensor_msgs/msg/PointCloud2.hpp>

#include "bench/common/hosts.h"
#include "bench/common/node_options.h"
#include "bench/common/raw_sockets.h"
#include "bench/common/statistics.h"
#include "bench/spine/spine.h"

namespace sft::bench {

namespace {

using sensor_msgs::msg::PointCloud2;
using F = PointCloud2::Field;

constexpr std::size_t field_bytes = 64;  // a length of 4 bytes, and 60 elements of one byte

PointCloud2 message() {
  PointCloud2 m;
  m.data.assign(field_bytes - 4, 1);
  return m;
}

void wait_served(const Publisher<PointCloud2>& publisher) {
  while (publisher.status().readers.empty() || !publisher.status().readers[0].served) pause_us(1000);
}

void ping(Exchange& exchange, std::uint64_t messages) {
  Node node = Node::open(udp_node_options("ping")).value();
  auto publisher = node.publisher<PointCloud2>("ping").value();
  const PointCloud2 m = message();
  std::atomic<std::uint64_t> rounds{0};
  std::int64_t sent_at = 0;
  const auto send = [&] {
    sent_at = now_ns();
    publisher.publish(m);
  };
  auto pong =
      node.subscriber<PointCloud2, F::data>("pong",
                                            [&](const auto& sample) {
                                              const std::int64_t now = now_ns();
                                              const std::uint64_t i = rounds.load();
                                              if (sample->data().size() != m.data.size() || i >= messages)
                                                return;
                                              exchange.sent_at[i] = 0;
                                              exchange.received_at[i] = (now - sent_at) / 2;
                                              rounds = i + 1;
                                              if (i + 1 < messages) send();
                                            })
          .value();
  wait_served(publisher);
  while (!exchange.ready.load()) pause_us(1000);
  send();
  std::uint64_t before = 0;
  while (rounds.load() < messages) {
    sleep_us(1'000'000);
    if (rounds.load() == before) {  // a datagram was lost, so the next sample is sent
      exchange.failed = rounds.load() == 0;
      send();
    }
    before = rounds.load();
  }
  exchange.received = messages;
}

void echo(Exchange& exchange, std::uint64_t messages) {
  Node node = Node::open(udp_node_options("pong")).value();
  auto publisher = node.publisher<PointCloud2>("pong").value();
  const PointCloud2 m = message();
  auto ping = node.subscriber<PointCloud2, F::data>("ping",
                                                    [&](const auto& sample) {
                                                      if (!sample->data().empty()) publisher.publish(m);
                                                    })
                  .value();
  wait_served(publisher);
  exchange.ready = true;
  while (exchange.received.load() < messages && !exchange.failed.load()) sleep_us(20'000);
}

}  // namespace

std::vector<Figure> udp_small(const Scale& scale) {
  const TwoHosts hosts;
  std::vector<double> ours, raw, ours_p99, raw_p99;
  for (int round = 0; round < scale.rounds; ++round) {
    Sides sides = hosts.sides([&](Exchange& e) { ping(e, scale.messages); },
                              [&](Exchange& e) { echo(e, scale.messages); });
    auto times = run_pair(sides, scale.messages);
    ours.push_back(quantile(times, 0.5));
    ours_p99.push_back(quantile(times, 0.99));
    times = raw_socket_ping_pong(scale.messages, field_bytes, Reading::sleeping, hosts);
    raw.push_back(quantile(times, 0.5));
    raw_p99.push_back(quantile(times, 0.99));
  }
  return {{"udp_small", median(ours), "us", median(raw), "blocking sockets, 64 B", 1.5},
          {"udp_small_p99", median(ours_p99), "us", median(raw_p99), "blocking sockets, 64 B", {}}};
}

}  // namespace sft::bench
