// Measures the memory of a node: the growth of its anonymous memory, as the kernel counts it, beyond that
// of Cyclone DDS with the same number of entities. It includes samples in the node's own pool, but none in
// shared memory.
#include <sft/sft.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <sensor_msgs/msg/Imu.hpp>
#include <string>

#include "bench/common/pair.h"
#include "bench/common/shared.h"
#include "bench/negotiation/negotiation.h"
#include "bench/negotiation/response.h"

namespace sft::bench {

namespace {

using sensor_msgs::msg::Imu;

constexpr std::size_t topics = 10;
constexpr int samples = 100;  // number of samples on each topic
constexpr int control_topics = 3;

/// Returns the anonymous memory of this process in MB.
double anonymous_memory() {
  std::ifstream map("/proc/self/smaps_rollup");
  for (std::string line; std::getline(map, line);) {
    if (line.starts_with("Anonymous:")) return std::stod(line.substr(line.find(':') + 1)) * 1024 / 1e6;
  }
  return 0;
}

/// Calls `run` in a new process. Returns the growth of the anonymous memory of that process until `run`
/// calls `measure`.
double in_new_process(const std::function<void(const std::function<void()>& measure)>& run) {
  const Shared<double> result;
  const pid_t child = fork();
  if (child == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    const double before = anonymous_memory();
    run([&] { *result = anonymous_memory() - before; });
    std::exit(0);
  }
  waitpid(child, nullptr, 0);
  return *result;
}

/// Opens a publisher and a subscriber of each topic, and exchanges samples.
void open_node(TransportChoice transport, const std::function<void()>& measure) {
  Node node = Node::open({.name = "node", .transport = transport}).value();
  std::vector<Publisher<Imu>> publishers;
  std::vector<Subscriber<Imu>> subscribers;
  for (std::size_t i = 0; i < topics; ++i) {
    publishers.push_back(node.publisher<Imu>("topic" + std::to_string(i)).value());
    subscribers.push_back(node.subscriber<Imu>("topic" + std::to_string(i)).value());
  }
  const auto ready = [&](const Publisher<Imu>& publisher) {
    const std::vector<PublisherStatus::Reader> readers = publisher.status().readers;
    const bool by_memory = !readers.empty() && readers[0].transport == TransportKind::shm;
    return !readers.empty() && readers[0].served && by_memory == (transport != TransportChoice::udp);
  };
  while (!std::ranges::all_of(publishers, ready)) sleep_us(10'000);
  const Imu message;
  for (int n = 0; n < samples; ++n) {
    for (std::size_t i = 0; i < topics; ++i) {
      publishers[i].publish(message);
      subscribers[i].wait(std::chrono::seconds(1));
      (void)subscribers[i].take();
    }
  }
  measure();
}

void open_cyclone(const std::function<void()>& measure) {
  const auto peer = cyclone_control_peer();
  std::vector<std::unique_ptr<Writer>> writers;
  std::vector<std::unique_ptr<Reader>> readers;
  for (int i = 0; i < control_topics; ++i) {
    const Topic topic{.name = "topic" + std::to_string(i), .durable = true};
    writers.push_back(peer->writer(topic));
    readers.push_back(peer->reader(topic, [](std::uint64_t) {}));
  }
  measure();
}

}  // namespace

std::vector<Figure> node_anonymous_memory() {
  const double cyclone = in_new_process(open_cyclone);
  const auto beyond = [&](TransportChoice transport) {
    return in_new_process([&](const auto& measure) { open_node(transport, measure); }) - cyclone;
  };
  const char* reference = "Cyclone DDS alone, beneath it";
  return {{"node_anonymous_memory", beyond(TransportChoice::automatic), "MB", cyclone, reference, 6, true},
          {"node_anonymous_memory_udp", beyond(TransportChoice::udp), "MB", cyclone, reference, 6, true}};
}

}  // namespace sft::bench
