#include <sft/sft.h>

#include <cmath>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <string>

#include "bench/common/hosts.h"
#include "bench/common/node_options.h"
#include "bench/common/shared.h"
#include "bench/common/statistics.h"
#include "bench/selection/messages.h"
#include "bench/selection/selection.h"

namespace sft::bench {

namespace {

using sensor_msgs::msg::PointCloud2;

constexpr std::int64_t period_us = 50'000;

/// Publishes the cloud at 20 Hz. The seconds of its stamp are the number of the sample.
void publish(Exchange& exchange, std::uint64_t samples) {
  Node node = Node::open(udp_node_options("lidar")).value();
  auto publisher = node.publisher<PointCloud2>("points").value();
  PointCloud2 cloud = ouster_cloud();
  wait_until([&] {
    const auto readers = publisher.status().readers;
    return exchange.ready.load() && !readers.empty() && readers[0].served;
  });
  for (std::uint64_t n = 1; n <= samples; ++n) {
    sleep_us(period_us);
    cloud.header.stamp.sec = static_cast<std::int32_t>(n);
    exchange.sent_at[n - 1] = now_ns();
    publisher.publish(cloud);
  }
  wait_until([&] { return exchange.received.load() >= samples; }, 2);
}

/// Subscribes to `fields`. Sets `bytes` to the bytes per sample that the link has received, with the
/// headers of all layers.
void subscribe(Exchange& exchange, const std::string& fields, std::uint64_t samples, double& bytes) {
  Node node = Node::open(udp_node_options("reader")).value();
  const DynamicType type = node.find_type("points", std::chrono::seconds(20)).value();
  const auto note = [&](const DynamicSample& sample) {
    const auto n = sample.view().find("header.stamp.sec").as<std::uint64_t>();
    if (!n || *n == 0 || *n > samples) return;
    exchange.received_at[*n - 1] = now_ns();
    exchange.received.store(*n, std::memory_order_release);
  };
  auto subscriber = node.subscriber("points", type, fields, {}, note).value();
  const LinkBytes before = link_bytes();
  exchange.ready = true;
  wait_until([&] { return exchange.received.load() >= samples; },
             2 + static_cast<double>(samples * period_us) / 1e6);
  bytes = static_cast<double>(link_bytes().received - before.received) /
          static_cast<double>(std::max<std::uint64_t>(subscriber.status().received, 1));
}

struct Measured {
  std::vector<double> us;  ///< times from publish() to the callback
  double bytes = 0;        ///< number of bytes per sample
};

Measured measure(const TwoHosts& hosts, const std::string& fields, std::uint64_t samples) {
  const Shared<double> bytes;
  const auto times =
      run_pair(hosts.sides([=](Exchange& e) { publish(e, samples); },
                           [&](Exchange& e) { subscribe(e, "header.stamp, " + fields, samples, *bytes); }),
               samples);
  return {times, *bytes};
}

}  // namespace

std::vector<Figure> parts_between_hosts(std::uint64_t samples, int rounds) {
  const TwoHosts hosts;
  const PointCloud2 cloud = ouster_cloud();
  Rounds part_us, whole_us;
  double bytes = 0;
  for (int round = 0; round < rounds; ++round) {
    const Measured part = measure(hosts, "data{x,y,z}", samples);
    const Measured whole = measure(hosts, "*", samples);
    part_us.add(part.us);
    whole_us.add(whole.us);
    bytes = part.bytes;
  }
  const double coordinates = 12.0 * cloud.width * cloud.height;
  constexpr double payload_bytes = 1472, header_bytes = 14 + 20 + 8;  // headers of Ethernet, IPv4 and UDP
  const double least = coordinates + std::ceil(coordinates / payload_bytes) * header_bytes;
  return {{"channels_xyz_wire", bytes, "B", least, "12 B a point in full datagrams, on the link", 1.02},
          {"channels_xyz_latency", part_us.p50(), "us", whole_us.p50(), "the whole cloud", 0.5}};
}

}  // namespace sft::bench
