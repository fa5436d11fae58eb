// A camera of 1280 x 720 pixels, whose exposure is a parameter that another program owns.
#include <sft/sft.h>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <sensor_msgs/msg/Image.hpp>
#include <std_msgs/msg/Float64.hpp>
#include <thread>
#include <utility>

using namespace std::chrono_literals;
using sensor_msgs::msg::Image;
using std_msgs::msg::Float64;

int main(int argc, char** argv) {
  const int count = argc > 1 ? std::atoi(argv[1]) : 300;
  std::atomic<double> exposure_ms{10};
  sft::Node node = sft::Node::open({.name = "camera"}).value();
  sft::Publisher<Image> images = node.publisher<Image>("camera/image").value();
  const sft::SubscriberOptions kept{.reliability = sft::reliable, .durability = sft::transient_local};
  const auto follow = [&](const sft::Sample<Float64>& value) {
    exposure_ms = value->data();
    std::printf("exposure %.1f ms\n", value->data());
    std::fflush(stdout);
  };
  const auto exposure = node.subscriber<Float64>("camera/exposure_ms", follow, kept).value();

  Image image{.height = 720, .width = 1280, .encoding = "rgb8", .step = 3 * 1280};
  image.header.frame_id = "camera";
  for (int i = 0; i < count; ++i) {
    image.header.stamp = sft::time_message<builtin_interfaces::msg::Time>(node.now());
    auto loan = images.loan_for_overwrite(image, {.data = 720 * 3840}).value();
    std::ranges::fill(loan->data(), static_cast<std::uint8_t>(exposure_ms.load()));
    std::move(loan).publish();
    std::this_thread::sleep_for(33ms);
  }
}
