// A fixture with nodes of a robot, which the tests examine with the command sft.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sft/sft.h>
#include <chrono>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <string>
#include <utility>

#include "tests/support/eventually.h"
#include "tests/support/pace.h"
#include "tests/support/small_cloud.h"
#include "tests/support/tool_process.h"

namespace sft::test {

using Json = nlohmann::json;
using sensor_msgs::msg::PointCloud2;
using F = PointCloud2::Field;
using namespace std::chrono_literals;
using ::testing::HasSubstr;
using ::testing::StartsWith;

class ToolTest : public ::testing::Test {
 protected:
  static Node open(const std::string& name, TransportChoice transport = TransportChoice::udp) {
    NodeOptions options{.name = name, .transport = transport};
    options.shm.daemon_idle_exit = 5s;
    return Node::open(options).value();
  }

  static PointCloud2 cloud() { return small_cloud("lidar, \"front\"", 1000); }

  Node robot = open("lidar");
};

/// Publishes one message periodically until it is destroyed.
template <class T>
class Publishing {
 public:
  Publishing(Publisher<T>& publisher, T message, std::chrono::milliseconds period = 10ms,
             bool stamped = false)
      : ticker_(
            period,
            [&publisher, message = std::move(message), stamped](std::uint32_t) mutable {
              if (stamped) {
                message.header.stamp =
                    time_message<builtin_interfaces::msg::Time>(std::chrono::system_clock::now());
              }
              publisher.publish(message);
            },
            Keeps::rate) {}

 private:
  Ticker ticker_;
};

}  // namespace sft::test
