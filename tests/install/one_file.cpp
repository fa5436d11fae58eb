// A program of one file, which can be built with a compiler and pkg-config. It publishes a string and
// subscribes to it.
#include <sft/sft.h>

#include <chrono>
#include <cstdio>
#include <std_msgs/msg/String.hpp>

using namespace std::chrono_literals;
using std_msgs::msg::String;

int main() {
  auto node = sft::Node::open({.name = "one_file"}).value();
  auto subscriber = node.subscriber<String, String::Field::data>("words").value();
  auto publisher = node.publisher<String>("words").value();
  for (int i = 0; i < 200; ++i) {
    publisher.publish({.data = "hello"});
    if (!subscriber.wait(100ms)) continue;
    const auto sample = subscriber.take();
    return std::printf("it says: %s\n", std::string(sample->data()).c_str()), 0;
  }
  return 1;
}
