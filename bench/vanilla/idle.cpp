// Measures idle nodes while there is no vanilla node. They are compared with nodes for which communication
// with vanilla nodes is turned off. Both are measured in the same seconds, on separate networks.
#include <sft/sft.h>

#include <filesystem>
#include <iterator>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <string>
#include <vector>

#include "bench/common/host_processes.h"
#include "bench/common/node_options.h"
#include "bench/vanilla/vanilla.h"

namespace sft::bench {

namespace {

using sensor_msgs::msg::PointCloud2;
using VanillaDds = NodeOptions::VanillaDds;

/// The maximum ratio of each figure to its reference. It is more than 1, because the numbers of datagrams and
/// pages vary by chance.
constexpr double idle_bound = 1.02;
constexpr std::int64_t joined_us = 5'000'000;
constexpr int nodes_of_host = 4;

int idle(VanillaDds choice) {
  NodeOptions options = udp_node_options("idle");
  options.vanilla_dds = choice;
  Node node = Node::open(options).value();
  const auto publisher = node.publisher<PointCloud2>("points").value();
  const auto subscriber = node.subscriber<PointCloud2>("others").value();
  for (;;) sleep_us(joined_us);
}

/// Idle nodes on two hosts.
class IdleNodes {
 public:
  explicit IdleNodes(VanillaDds choice) {
    for (int node = 0; node < 2 * nodes_of_host; ++node)
      started_.push_back(
          processes_.start(static_cast<std::size_t>(node % 2), [choice] { return idle(choice); }));
  }

  double sent_bytes() const { return static_cast<double>(processes_.link_bytes().sent); }
  double memory_mb() const {
    return processes_.anonymous_bytes() / 1e6 / static_cast<double>(started_.size());
  }
  double threads() const {
    double threads = 0;
    for (const pid_t process : started_) {
      const std::filesystem::directory_iterator tasks("/proc/" + std::to_string(process) + "/task");
      threads += static_cast<double>(std::distance(begin(tasks), end(tasks)));
    }
    return threads / static_cast<double>(started_.size());
  }

 private:
  HostProcesses processes_{1};
  std::vector<pid_t> started_;
};

}  // namespace

std::vector<Figure> idle_without_vanilla(const VanillaScale& scale) {
  const IdleNodes automatic(VanillaDds::automatic), never(VanillaDds::never);
  sleep_us(joined_us);
  const double before = automatic.sent_bytes(), before_of_never = never.sent_bytes();
  sleep_us(static_cast<std::int64_t>(scale.idle_s * 1e6));
  const double per_s = scale.idle_s * 2 * nodes_of_host;
  const double bytes = (automatic.sent_bytes() - before) / per_s;
  const double bytes_of_never = (never.sent_bytes() - before_of_never) / per_s;
  const char* reference = "VanillaDds::never, each node";
  return {
      {"idle_without_vanilla_bytes", bytes, "B/s", bytes_of_never, reference, idle_bound},
      {"idle_without_vanilla_threads", automatic.threads(), "", never.threads(), reference, 1},
      {"idle_without_vanilla_memory", automatic.memory_mb(), "MB", never.memory_mb(), reference, idle_bound}};
}

}  // namespace sft::bench
