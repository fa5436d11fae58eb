// publisher [COUNT]: publishes the state of a battery ten times per second. At the end it prints which
// fields were sent to each reader.
#include <sft/sft.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <robot_msgs/msg/Battery.hpp>
#include <thread>

using namespace std::chrono_literals;
using robot_msgs::msg::Battery;

int main(int argc, char** argv) {
  const int count = argc > 1 ? std::atoi(argv[1]) : 100;

  auto node = sft::Node::open({.name = "battery"});
  if (!node) return std::fprintf(stderr, "%s\n", node.error().message.c_str()), 1;
  auto publisher = node->publisher<Battery>("battery");
  if (!publisher) return std::fprintf(stderr, "%s\n", publisher.error().message.c_str()), 1;

  Battery battery{
      .serial = "B-17", .volts = 25.2F, .charge = 1, .cell_volts = {4.2F, 4.2F, 4.2F, 4.2F, 4.2F, 4.2F}};
  for (int i = 0; i < count; ++i) {
    battery.charge -= 0.001F;
    publisher->publish(battery);
    std::this_thread::sleep_for(100ms);
  }

  const sft::NodeSnapshot now = node->snapshot();
  for (const sft::NodeSnapshot::Publisher::Reader& reader : now.publishers.at(0).readers) {
    std::printf("%s is sent {%s} by %s\n", reader.node.c_str(), reader.fields.c_str(),
                to_string(reader.transport));
  }
}
