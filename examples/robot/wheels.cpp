// Publishes messages of the robot's own types, and reads some fields of them.
#include <sft/sft.h>
#include <chrono>
#include <cstdio>
#include <my_robot_msgs/msg/Wheels.hpp>
#include <string>
#include <thread>

using namespace std::chrono_literals;
using my_robot_msgs::msg::Wheels;
using F = Wheels::Field;

int main() {
  sft::Node node = sft::Node::open({.name = "base", .namespace_ = "robot"}).value();
  auto wheels = node.publisher<Wheels>("wheels", {.reliability = sft::reliable}).value();
  const auto print = [](const auto& sample) {
    for (const auto wheel : sample->wheels())
      std::printf("%s %.1f rad/s%s\n", std::string(wheel.name()).c_str(), wheel.speed(),
                  sample->state() == Wheels::SLIPPING ? ", slipping" : "");
    std::fflush(stdout);
  };
  const auto speeds = node.subscriber<Wheels, F::state | F::wheels.each.name | F::wheels.each.speed>(
                              "wheels", print, {.reliability = sft::reliable})
                          .value();
  if (!wheels.wait_for_subscribers(1, 5s)) return 1;

  Wheels message;
  message.wheels = {{.name = "left", .speed = 1}, {.name = "right", .speed = 2, .currents = {1, 2, 3, 4}}};
  message.state = Wheels::SLIPPING;
  if (wheels.publish(message) == sft::PublishStatus::invalid) std::puts(wheels.why_invalid().c_str());
  message.wheels[0].name = "a name of more than sixteen characters";
  if (wheels.publish(message) == sft::PublishStatus::invalid) std::puts(wheels.why_invalid().c_str());
  std::this_thread::sleep_for(500ms);
}
