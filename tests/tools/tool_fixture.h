// A robot for the command sft to look at.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sft/sft.h>
#include <atomic>
#include <chrono>
#include <nlohmann/json.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <string>
#include <thread>

#include "tests/support/eventually.h"
#include "tests/tools/tool_process.h"

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

  static PointCloud2 cloud() {
    PointCloud2 c;
    c.header.stamp.sec = 7;
    c.header.frame_id = "lidar, \"front\"";
    c.height = 1;
    c.width = 1024;
    c.fields.resize(2);
    c.fields[0].name = "x";
    c.fields[1].name = "y";
    c.data.resize(1000, 9);
    return c;
  }

  Node robot = open("lidar");
};

/// Publishes one message again and again while it lives.
template <class T>
class Publishing {
 public:
  Publishing(Publisher<T>& publisher, T message, std::chrono::milliseconds period = 10ms,
             bool stamped = false)
      : thread_([this, &publisher, message = std::move(message), period, stamped]() mutable {
          for (auto next = std::chrono::steady_clock::now(); !ends_;
               std::this_thread::sleep_until(next += period)) {
            if (stamped) stamp(message);
            publisher.publish(message);
          }
        }) {}
  ~Publishing() {
    ends_ = true;
    thread_.join();
  }
  Publishing(const Publishing&) = delete;
  Publishing& operator=(const Publishing&) = delete;

 private:
  static void stamp(T& message) {
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    message.header.stamp.sec = static_cast<std::int32_t>(now / 1s);
    message.header.stamp.nanosec = static_cast<std::uint32_t>(std::chrono::nanoseconds(now % 1s).count());
  }

  std::atomic<bool> ends_{false};
  std::thread thread_;
};

}  // namespace sft::test
