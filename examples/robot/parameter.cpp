// The owner of a parameter. Programs that come later get its present value, too.
#include <sft/sft.h>
#include <chrono>
#include <cstdio>
#include <std_msgs/msg/Float64.hpp>
#include <thread>

using namespace std::chrono_literals;
using std_msgs::msg::Float64;

int main() {
  sft::Node node = sft::Node::open({.name = "exposure"}).value();
  const sft::PublisherOptions kept{.reliability = sft::reliable, .durability = sft::transient_local};
  sft::Publisher<Float64> exposure = node.publisher<Float64>("camera/exposure_ms", kept).value();
  for (const double ms : {5.0, 20.0, 40.0}) {
    exposure.publish({.data = ms});
    std::this_thread::sleep_for(500ms);
  }
  if (!exposure.wait_for_subscribers(1, 10s)) return std::puts("no camera follows"), 1;
  std::this_thread::sleep_for(1s);
}
