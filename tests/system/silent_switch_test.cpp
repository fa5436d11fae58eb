// Whole nodes on hosts between which only short packets arrive. Longer ones are lost without an error
// message, as in some tunnels, although the network devices of the hosts accept 1500 bytes. Or the network
// devices themselves accept only short packets.
#include <gtest/gtest.h>
#include <sft/msg_text.h>
#include <sft/sft.h>

#include <array>
#include <atomic>
#include <memory>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/eventually.h"
#include "tests/support/isolated_host.h"
#include "tests/system/node_process.h"
#include "tools/hosts/network.h"

namespace sft::test {
namespace {

using sensor_msgs::msg::PointCloud2;
using F = PointCloud2::Field;
using namespace std::chrono_literals;

/// The sizes of samples in bytes: one datagram that is short enough, one datagram that is too long, a few
/// datagrams, and many datagrams.
constexpr std::array<std::size_t, 4> sizes{100, 1300, 9000, 200'000};
constexpr std::array<Reliability, 2> reliabilities{Reliability::best_effort, Reliability::reliable};
constexpr std::size_t topics = sizes.size() * reliabilities.size();

std::string name_of(std::size_t topic) {
  return "points" + std::to_string(sizes[topic / 2]) + to_string(reliabilities[topic % 2]);
}

struct Report {
  std::atomic<bool> failed{false};
  std::array<std::atomic<std::uint64_t>, topics> taken{};
  std::atomic<std::size_t> limits_in_status{0};  ///< the number of pairs whose status reports the limit on
                                                 ///< the length of datagrams
  std::atomic<std::size_t> limits_in_log{0};
  std::atomic<std::size_t> in_groups{0};  ///< the number of pairs that share a multicast group
};

/// The text that the status and the log have about the path to the second host. They also name the longest
/// length that is known to arrive, which grows while longer ones are tried.
constexpr std::string_view limit = " bytes do not arrive at '10.77.0.2': samples go there in shorter ones";

void publish(Node& node, Report& report) {
  std::vector<Publisher<PointCloud2>> publishers;
  for (std::size_t i = 0; i < topics; ++i)
    publishers.push_back(
        node.publisher<PointCloud2>(name_of(i), {.reliability = reliabilities[i % 2]}).value());
  for (;;) {
    std::size_t limits = 0, in_groups = 0;
    for (std::size_t i = 0; i < topics; ++i) {
      PointCloud2 cloud;
      cloud.data.resize(sizes[i / 2]);
      publishers[i].publish(cloud);
      for (const auto& reader : publishers[i].status().readers) {
        limits += reader.reason.find(limit) != std::string::npos ? 1 : 0;
        in_groups += reader.multicast.starts_with("group ") ? 1 : 0;
      }
    }
    report.limits_in_status = limits;
    report.in_groups = in_groups;
    poll(nullptr, 0, 50);
  }
}

void subscribe(Node& node, Report& report) {
  std::vector<Subscriber<PointCloud2, F::data>> subscribers;
  for (std::size_t i = 0; i < topics; ++i)
    subscribers.push_back(
        node.subscriber<PointCloud2, F::data>(name_of(i), {.reliability = reliabilities[i % 2], .depth = 100})
            .value());
  for (;;) {
    for (std::size_t i = 0; i < topics; ++i) {
      while (subscribers[i].take()) ++report.taken[i];
    }
    poll(nullptr, 0, 5);
  }
}

/// Returns a type whose description has about 30 KB.
DynamicType long_type() {
  std::string text;
  for (int i = 0; i < 300; ++i) text += "float64 " + std::string(90, 'x') + std::to_string(i) + "\n";
  return from_msg("test_msgs/msg/Long", text).value();
}

void publish_long_type(Node& node, Report&) {
  auto publisher = node.publisher("long", long_type()).value();
  for (;;) {
    EXPECT_EQ(publisher.publish_yaml("{}"), PublishStatus::ok);
    poll(nullptr, 0, 50);
  }
}

void subscribe_to_long_type(Node& node, Report& report) {
  auto subscriber = node.subscriber("long", long_type(), "*").value();
  for (;;) {
    while (subscriber.take()) ++report.taken[0];
    poll(nullptr, 0, 5);
  }
}

class ShortPathsTest : public testing::TestWithParam<std::size_t> {
 protected:
  void SetUp() override {
    if (!isolation_refusal().empty()) GTEST_SKIP() << isolation_refusal();
    auto network = hosts::EmulatedNetwork::create(host_count);
    if (!network) GTEST_SKIP() << network.error().message;
    network_ = std::make_unique<hosts::EmulatedNetwork>(std::move(*network));
    for (std::size_t i = 0; i < host_count; ++i) {
      ASSERT_TRUE(
          network_->host(i).run({"sh", "-ec", "ethtool -K eth0 tx-udp-segmentation off > /dev/null"}));
    }
  }

  using NodeProcess = NodeProcessWith<Report>;
  static constexpr std::size_t host_count = 3;
  static NodeOptions options(const char* name) { return {.name = name, .transport = TransportChoice::udp}; }
  static void expect_all_sizes(const NodeProcess& subscriber) {
    for (std::size_t i = 0; i < topics; ++i) {
      EXPECT_TRUE(eventually([&] { return subscriber.report().taken[i] > 10; }))
          << name_of(i) << ": " << subscriber.report().taken[i];
    }
  }

  std::unique_ptr<hosts::EmulatedNetwork> network_;
};

/// The switch silently drops longer packets than the parameter says.
class SilentSwitchTest : public ShortPathsTest {
 protected:
  void SetUp() override {
    ShortPathsTest::SetUp();
    if (IsSkipped()) return;
    const Result<void> done =
        network_->run_on_switch({"sh", "-ec",
                                 "nft add table bridge silent; "
                                 "nft add chain bridge silent f '{ type filter hook forward priority 0; }'; "
                                 "nft add rule bridge silent f meta length \\> " +
                                     std::to_string(GetParam()) + " drop"});
    if (!done) GTEST_SKIP() << done.error().message;
  }
};

INSTANTIATE_TEST_SUITE_P(PacketsOf, SilentSwitchTest, testing::Values(1000U, 1200U, 1280U),
                         testing::PrintToStringParamName());

TEST_P(SilentSwitchTest, SamplesOfEverySizeArriveAndTheLogNamesTheLimitOnce) {
  SharedWithChildren<Report> reported;
  NodeOptions with_log = options("publisher");
  with_log.log = [&](LogLevel, std::string_view line) {
    if (line.find(limit) != line.npos) ++reported->limits_in_log;
  };
  const NodeProcess publisher(network_->host(0), with_log, publish);
  const NodeProcess subscriber(network_->host(1), options("subscriber"), subscribe);
  expect_all_sizes(subscriber);
  EXPECT_TRUE(eventually([&] { return publisher.report().limits_in_status == topics; }));
  EXPECT_TRUE(eventually([&] { return reported->limits_in_log > 0; }));
  EXPECT_EQ(reported->limits_in_log, 1U);
}

/// Two hosts request the same fields. So one copy by multicast serves both of them, once the maximum length
/// of a multicast datagram is known.
TEST_P(SilentSwitchTest, SamplesOfEverySizeArriveAtHostsThatShareACopy) {
  const NodeProcess publisher(network_->host(0), options("publisher"), publish);
  const NodeProcess one(network_->host(1), options("one"), subscribe);
  const NodeProcess other(network_->host(2), options("other"), subscribe);
  const auto all_come = [&] {
    std::array<std::uint64_t, topics> of_one{}, of_other{};
    for (std::size_t i = 0; i < topics; ++i) {
      of_one[i] = one.report().taken[i];
      of_other[i] = other.report().taken[i];
    }
    for (std::size_t i = 0; i < topics; ++i) {
      EXPECT_TRUE(eventually([&] { return one.report().taken[i] > of_one[i] + 10; })) << name_of(i);
      EXPECT_TRUE(eventually([&] { return other.report().taken[i] > of_other[i] + 10; })) << name_of(i);
    }
  };
  all_come();
  constexpr std::size_t pairs_of_large_samples = 8;
  EXPECT_TRUE(eventually([&] { return publisher.report().in_groups >= pairs_of_large_samples; }))
      << publisher.report().in_groups;
  all_come();
}

TEST_P(SilentSwitchTest, NodesFindATopicWhoseTypeTakesManyDatagramsToDescribe) {
  const NodeProcess publisher(network_->host(0), options("publisher"), publish_long_type);
  const NodeProcess subscriber(network_->host(1), options("subscriber"), subscribe_to_long_type);
  EXPECT_TRUE(eventually([&] { return subscriber.report().taken[0] > 3; }));
  EXPECT_FALSE(publisher.report().failed || subscriber.report().failed);
}

/// The hosts and the switch know that their interfaces carry no longer packets than the parameter says.
class ShortLinksTest : public ShortPathsTest {
 protected:
  void SetUp() override {
    ShortPathsTest::SetUp();
    if (IsSkipped()) return;
    const std::string mtu = " mtu " + std::to_string(GetParam());
    for (std::size_t i = 0; i < host_count; ++i) {
      ASSERT_TRUE(network_->host(i).run({"sh", "-ec", "ip link set eth0" + mtu}));
      ASSERT_TRUE(network_->run_on_switch({"sh", "-ec", "ip link set " + network_->port(i) + mtu}));
    }
  }
};

INSTANTIATE_TEST_SUITE_P(PacketsOf, ShortLinksTest, testing::Values(400U, 576U, 1000U),
                         testing::PrintToStringParamName());

TEST_P(ShortLinksTest, SamplesOfEverySizeArrive) {
  const NodeProcess publisher(network_->host(0), options("publisher"), publish);
  const NodeProcess subscriber(network_->host(1), options("subscriber"), subscribe);
  expect_all_sizes(subscriber);
}

TEST_P(ShortLinksTest, NodesFindATopicWhoseTypeTakesManyDatagramsToDescribe) {
  const NodeProcess publisher(network_->host(0), options("publisher"), publish_long_type);
  const NodeProcess subscriber(network_->host(1), options("subscriber"), subscribe_to_long_type);
  EXPECT_TRUE(eventually([&] { return subscriber.report().taken[0] > 3; }));
  EXPECT_FALSE(publisher.report().failed || subscriber.report().failed);
}

}  // namespace
}  // namespace sft::test
