// The base of tests with a publisher's node and a subscriber's node, which are run over each transport with
// the same expectations.
#pragma once

#include <gtest/gtest.h>

#include <sft/sft.h>
#include <atomic>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <string>
#include <string_view>

#include "tests/support/eventually.h"

namespace sft::test {

using sensor_msgs::msg::PointCloud2;
using F = PointCloud2::Field;
using namespace std::chrono_literals;

enum class Way { shm, udp, udp_sockets };

/// True if the test provokes lines in the log.
inline std::atomic<bool> warnings_expected{false};
/// If not null, the test provokes lines with this text and no others.
inline std::atomic<const char*> expected_warning{nullptr};

/// Returns true if the test accepts this line in the log. Some lines are always accepted, because they
/// occur on a busy machine: sftd answers late, or a callback is late. In these cases the test only has to
/// wait longer.
inline bool is_expected(std::string_view line) {
  const auto has = [&](const char* text) { return text != nullptr && line.find(text) != line.npos; };
  return warnings_expected || has(expected_warning) || has("sftd did not answer in time") ||
         has(" does not answer; is it stopped") || has(": a sample has waited for its callback for ") ||
         has(": its callback has run for ");
}

inline NodeOptions node_options(Way way, const std::string& name) {
  NodeOptions options{.name = name};
  options.transport = way == Way::shm ? TransportChoice::shm : TransportChoice::udp;
  options.udp.use_io_uring = way != Way::udp_sockets;
  options.shm.daemon_idle_exit = 5s;
  options.log = [](LogLevel level, std::string_view text) {
    if (level >= LogLevel::warning && !is_expected(text)) ADD_FAILURE() << "logged: " << text;
  };
  return options;
}

class PubSubTest : public ::testing::TestWithParam<Way> {
 protected:
  PubSubTest() {
    warnings_expected = false;
    expected_warning = nullptr;
  }
  Node open(const std::string& name) { return Node::open(node_options(GetParam(), name)).value(); }

  template <class P>
  static std::size_t served(const P& publisher) {
    std::size_t n = 0;
    for (const PublisherStatus::Reader& reader : publisher.status().readers) n += reader.served ? 1 : 0;
    return n;
  }
  template <class P>
  static void expect_served(const P& publisher, std::size_t readers) {
    ASSERT_TRUE(eventually([&] { return served(publisher) == readers; })) << "served: " << served(publisher);
  }

  static PointCloud2 cloud(std::uint32_t number, std::size_t bytes = 1000) {
    PointCloud2 c;
    c.header.stamp.sec = static_cast<std::int32_t>(number);
    c.header.frame_id = "lidar";
    c.height = number;
    c.width = number + 1;
    c.fields.resize(2);
    c.fields[1].name = "y";
    c.data.resize(bytes);
    for (std::size_t i = 0; i < bytes; i += 97) c.data[i] = static_cast<std::uint8_t>(i + number);
    return c;
  }

  bool in_shared_memory() const { return GetParam() == Way::shm; }
};

inline std::string way_name(const ::testing::TestParamInfo<Way>& info) {
  return info.param == Way::shm ? "shm" : info.param == Way::udp ? "udp" : "udp_sockets";
}

}  // namespace sft::test
