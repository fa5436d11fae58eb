// subscriber: prints the charge of the battery until no more samples arrive. It declares two fields, so that
// only these are sent to it.
#include <sft/sft.h>

#include <chrono>
#include <cstdio>
#include <robot_msgs/msg/Battery.hpp>
#include <string>

using namespace std::chrono_literals;
using robot_msgs::msg::Battery;
using F = Battery::Field;

int main() {
  auto node = sft::Node::open({.name = "monitor"});
  if (!node) return std::fprintf(stderr, "%s\n", node.error().message.c_str()), 1;
  auto subscriber = node->subscriber<Battery, F::serial | F::charge>("battery");
  if (!subscriber) return std::fprintf(stderr, "%s\n", subscriber.error().message.c_str()), 1;

  auto timeout = 30s;  // the time to start a publisher
  while (subscriber->wait(timeout)) {
    while (const auto sample = subscriber->take()) {
      const std::string serial(sample->serial());
      std::printf("battery %s: %.1f %%\n", serial.c_str(), 100 * static_cast<double>(sample->charge()));
      timeout = 2s;
    }
  }
  std::printf("shared memory: %s\n", node->status().shm.c_str());
}
