// The robot's mode is set by a service.
#include <sft/sft.h>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <my_robot_msgs/srv/SetMode.hpp>
#include <string>

using namespace std::chrono_literals;
using my_robot_msgs::srv::SetMode;

int main() {
  sft::Node node = sft::Node::open({.name = "robot"}).value();
  const auto set = [](const SetMode::Request& request) -> sft::Result<SetMode::Response> {
    if (request.mode > SetMode::Request::DRIVE)
      return sft::fail(sft::Errc::invalid_argument, "there is no mode " + std::to_string(request.mode));
    return SetMode::Response{.success = true, .message = "done"};
  };
  const auto service = sft::Service<SetMode>::open(node, "set_mode", set).value();

  sft::Node operator_node = sft::Node::open({.name = "operator"}).value();
  auto client = sft::Client<SetMode>::open(operator_node, "set_mode").value();
  for (const std::uint8_t mode : {SetMode::Request::DRIVE, std::uint8_t{9}}) {
    const auto response = client.call({.mode = mode}, 5s);
    std::printf("%s\n", response ? response->message.c_str() : response.error().message.c_str());
  }
}
