// Measures bytes on the link with the interface's counters: per sample of a diagnostic subscriber (height and
// width of a 6.3 MB point cloud), and per second of an idle node.
#include <sft/sft.h>
#include <sensor_msgs/msg/PointCloud2.hpp>

#include "bench/common/hosts.h"
#include "bench/common/node_options.h"
#include "bench/udp/udp.h"

namespace sft::bench {

namespace {

using sensor_msgs::msg::PointCloud2;
using F = PointCloud2::Field;

constexpr int phase_seconds = 20;  // longer than the longest period of control traffic
constexpr std::uint64_t samples = 25 * phase_seconds;

/// Exchange::sent has the number of the phase. 1: both sides are matched and quiet; 2: publishing; 3:
/// published.
void publish(Exchange& exchange) {
  Node node = Node::open(udp_node_options("lidar")).value();
  auto publisher = node.publisher<PointCloud2>("points").value();
  while (publisher.status().readers.empty()) sleep_us(1000);
  PointCloud2 cloud;
  cloud.data.resize(6'291'456);
  sleep_us(4'000'000);  // the time in which the traffic of joining ends
  exchange.sent = 1;
  while (exchange.received.load() < 1) sleep_us(1000);
  for (std::uint64_t i = 0; i < samples; ++i) {
    publisher.publish(cloud);
    sleep_us(std::int64_t{phase_seconds} * 1'000'000 / static_cast<std::int64_t>(samples));
  }
  exchange.sent = 2;
  while (exchange.received.load() < 2) sleep_us(1000);
}

/// Writes four numbers to received_at: the bytes sent and received in the quiet phase, and the bytes and
/// samples received in the publishing phase.
void subscribe(Exchange& exchange) {
  Node node = Node::open(udp_node_options("diagnostic")).value();
  std::atomic<std::int64_t> received{0};
  auto subscriber =
      node.subscriber<PointCloud2, F::height | F::width>("points", [&](const auto&) { ++received; }).value();
  while (exchange.sent.load() < 1) sleep_us(1000);
  const LinkBytes begin = link_bytes();
  sleep_us(std::int64_t{phase_seconds} * 1'000'000);
  const LinkBytes quiet = link_bytes();
  const std::int64_t from = now_ns();
  exchange.received = 1;
  while (exchange.sent.load() < 2) sleep_us(1000);
  const LinkBytes end = link_bytes();
  exchange.received_at[0] = quiet.sent - begin.sent;
  exchange.received_at[1] = quiet.received - begin.received;
  exchange.received_at[2] = end.received - quiet.received;
  exchange.received_at[3] = received.load();
  exchange.received_at[4] = now_ns() - from;
  exchange.received = 2;
}

}  // namespace

std::vector<Figure> diagnostic_bytes() {
  const TwoHosts hosts;
  // The figures were multiplied by 1000, since run_pair() divides times by 1000.
  const auto figures = run_pair(hosts.sides(publish, subscribe), 5);
  if (figures.size() < 5 || figures[3] == 0) return {};
  const double idle_sent = figures[0] * 1000 / phase_seconds;
  const double idle_received = figures[1] * 1000 / phase_seconds;
  const double seconds = figures[4] * 1000 / 1e9;
  const double received = figures[3] * 1000;
  return {{"diagnostic_wire_bytes",
           (figures[2] * 1000 - idle_received * seconds) / received,
           "B",
           {},
           "per sample of 6.3 MB, with link layer",
           90},
          {"idle_control_bytes_per_s", idle_sent, "B/s", {}, "sent by one node", 300}};
}

}  // namespace sft::bench
