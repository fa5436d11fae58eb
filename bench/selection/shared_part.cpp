#include <sft/sft.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <string>
#include <vector>

#include "bench/common/hosts.h"
#include "bench/common/node_options.h"
#include "bench/common/process.h"
#include "bench/common/shared.h"
#include "bench/selection/messages.h"
#include "bench/selection/selection.h"

namespace sft::bench {

namespace {

using sensor_msgs::msg::PointCloud2;

constexpr std::size_t readers_of_one_part = 4;
constexpr std::int64_t pause_between_clouds_us = 100'000;
constexpr double timeout_s = 60;

struct Progress {
  std::atomic<bool> done{false};
  std::atomic<std::size_t> read{0};  ///< number of samples that were read, summed over the readers
  double bytes = 0;                  ///< bytes per sample that the publisher's host has sent
};

/// Publishes until all readers are in a multicast group. After that, counts the bytes.
void publish_to_all(Progress& progress, std::uint64_t samples) {
  Node node = Node::open(udp_node_options("lidar")).value();
  auto publisher = node.publisher<PointCloud2>("points").value();
  const PointCloud2 cloud = ouster_cloud();
  wait_until(
      [&] {
        publisher.publish(cloud);
        sleep_us(pause_between_clouds_us);
        const auto readers = publisher.status().readers;
        const auto hears = [](const PublisherStatus::Reader& reader) {
          return reader.multicast.starts_with("group ") && !reader.multicast.ends_with("more");
        };
        return readers.size() == readers_of_one_part && std::ranges::all_of(readers, hears);
      },
      timeout_s);
  const LinkBytes before = link_bytes();
  for (std::uint64_t n = 0; n < samples; ++n) {
    publisher.publish(cloud);
    sleep_us(pause_between_clouds_us);
  }
  progress.bytes = static_cast<double>(link_bytes().sent - before.sent) / static_cast<double>(samples);
  progress.done = true;
}

void read_part(Progress& progress) {
  Node node = Node::open(udp_node_options("reader")).value();
  const DynamicType type = node.find_type("points", std::chrono::seconds(20)).value();
  auto subscriber = node.subscriber("points", type, "data{x,y,z}").value();
  while (!progress.done) {
    if (subscriber.wait(std::chrono::milliseconds(20)) && subscriber.take()) ++progress.read;
  }
}

}  // namespace

std::vector<Figure> shared_part_of_hosts(std::uint64_t samples) {
  const hosts::EmulatedNetwork network = make_hosts(1 + readers_of_one_part, Trains::cut);
  const Shared<Progress> progress;
  const auto start_at = [&](std::size_t host, const std::function<void()>& run) {
    return start_process([&network, host, run] {
      if (!network.host(host).enter()) return 1;
      run();
      return 0;
    });
  };
  std::vector<pid_t> processes;
  for (std::size_t host = 1; host <= readers_of_one_part; ++host)
    processes.push_back(start_at(host, [&] { read_part(*progress); }));
  processes.push_back(start_at(0, [&] { publish_to_all(*progress, samples); }));
  for (const pid_t process : processes) {
    if (!succeeds(process)) return {};
  }
  const PointCloud2 cloud = ouster_cloud();
  const double coordinates = 12.0 * cloud.width * cloud.height;
  constexpr double payload_bytes = 1472, header_bytes = 14 + 20 + 8;  // headers of Ethernet, IPv4 and UDP
  const double one_copy = coordinates + std::ceil(coordinates / payload_bytes) * header_bytes;
  return {{"channels_group_wire", progress->bytes, "B", one_copy,
           "one copy of x, y and z in full datagrams, for four hosts", 1.05}};
}

}  // namespace sft::bench
