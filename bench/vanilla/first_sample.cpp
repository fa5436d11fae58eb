// Measures how soon a starting vanilla reader receives its first sample from a program on another host that
// has been running for a while. The program sends a thousand samples per second, so the wait for the next
// sample is short. A program with SFT is measured in two cases: it is already in the domain of DDS nodes,
// because it has found another DDS node before, or it has to join this domain first.
#include <sft/sft.h>

#include <atomic>
#include <functional>
#include <sensor_msgs/msg/PointCloud2.hpp>

#include "bench/common/hosts.h"
#include "bench/common/node_options.h"
#include "bench/common/statistics.h"
#include "bench/vanilla/plain.h"
#include "bench/vanilla/vanilla.h"

namespace sft::bench {

namespace {

using sensor_msgs::msg::PointCloud2;

constexpr double first_sample_bound = 1.2;
constexpr std::int64_t alone_us = 300'000, period_us = 1000;

void write_until_received(Exchange& exchange, const std::function<void()>& write) {
  const std::int64_t alone_until = now_ns() + alone_us * 1000;
  while (exchange.received == 0 && !exchange.failed) {
    write();
    sleep_us(period_us);
    if (now_ns() > alone_until) exchange.sent = 1;
  }
}

void publish_small(Exchange& exchange, NodeOptions::VanillaDds choice) {
  NodeOptions options = udp_node_options("writer");
  options.vanilla_dds = choice;
  Node node = Node::open(options).value();
  auto publisher = node.publisher<PointCloud2>("points").value();
  const PointCloud2 cloud;
  write_until_received(exchange, [&] { publisher.publish(cloud); });
}

void write_small(Exchange& exchange) {
  PlainWriter writer(0);
  write_until_received(exchange, [&] { writer.write(1); });
}

void read_one(Exchange& exchange) {
  wait_until([&] { return exchange.sent != 0; });
  exchange.sent_at[0] = now_ns();
  const PlainReader reader([&](std::uint32_t) {
    if (exchange.received == 0) exchange.note_receipt(1);
  });
  exchange.failed = !wait_until([&] { return exchange.received != 0; });
}

}  // namespace

std::vector<Figure> vanilla_first_sample(const VanillaScale& scale) {
  const TwoHosts hosts;
  std::vector<double> ours, joining, theirs;
  const auto start = [&](const std::function<void(Exchange&)>& write, std::vector<double>& ms) {
    for (const double us : run_pair(hosts.sides(write, read_one), 1)) ms.push_back(us / 1000);
  };
  for (int i = 0; i < scale.starts; ++i) {
    start([](Exchange& e) { publish_small(e, NodeOptions::VanillaDds::always); }, ours);
    start([](Exchange& e) { publish_small(e, NodeOptions::VanillaDds::automatic); }, joining);
    start(write_small, theirs);
  }
  const char* reference = "of a Cyclone DDS writer";
  return {{"first_sample", quantile(ours, 0.5), "ms", quantile(theirs, 0.5), reference, first_sample_bound},
          {"first_sample_p90", quantile(ours, 0.9), "ms", quantile(theirs, 0.9), reference, {}},
          {"first_sample_joining", quantile(joining, 0.5), "ms", quantile(theirs, 0.5), reference, {}}};
}

}  // namespace sft::bench
