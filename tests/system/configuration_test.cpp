// Nodes report the parts of their configuration that they cannot apply, with the reason.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <sft/sft.h>
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <optional>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/eventually.h"
#include "tests/support/isolated_host.h"
#include "tests/support/other_threads.h"
#include "tests/support/pace.h"

namespace sft::test {
namespace {

using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;

using sensor_msgs::msg::PointCloud2;
using namespace std::chrono_literals;

class ConfigurationTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!isolation_refusal().empty()) GTEST_SKIP() << isolation_refusal();
  }
  /// Returns options with that configuration, and with a domain that no other test of this process has
  /// opened.
  NodeOptions with(const std::string& cyclonedds_config) {
    NodeOptions options;
    options.domain = domain_;
    options.transport = TransportChoice::udp;
    options.cyclonedds_config = cyclonedds_config;
    options.log = [this](LogLevel level, std::string_view text) {
      const std::scoped_lock lock(mutex_);
      if (level == LogLevel::warning) warnings_ += text;
    };
    return options;
  }
  std::string warnings() {
    const std::scoped_lock lock(mutex_);
    return warnings_;
  }
  /// Waits until a warning with that text is logged, because the log is written on another thread.
  bool is_warned_of(const std::string& text) {
    return eventually([&] { return warnings().find(text) != std::string::npos; });
  }
  std::string take_warnings() {
    const std::scoped_lock lock(mutex_);
    return std::exchange(warnings_, {});
  }
  static std::string error_of(const NodeOptions& options) {
    const auto node = Node::open(options);
    return node ? "it opens" : node.error().message;
  }

 private:
  static inline std::uint32_t domains_ = 0;
  const std::uint32_t domain_ = domains_ += 2;
  std::mutex mutex_;
  std::string warnings_;
};

TEST_F(ConfigurationTest, WhatDoesNotHoldOfItIsLoggedAndInTheStatus) {
  const Node node = Node::open(with("<SharedMemory><Enable>true</></>")).value();
  const std::string difference = "SharedMemory/Enable is 'false', not 'true' as CYCLONEDDS_URI says: ";
  EXPECT_TRUE(is_warned_of(difference)) << warnings();
  EXPECT_THAT(node.status().discovery, HasSubstr(difference));
  EXPECT_THAT(node.status().discovery, HasSubstr("by multicast on lo"));
  EXPECT_EQ(node.status().discovery_warnings.size(), 1U);
  EXPECT_EQ(node.status().discovery_interfaces, std::vector<std::string>{"lo"});
}

TEST_F(ConfigurationTest, AnSftdThatDoesNotExistIsAWarningThatSaysWhoNamesIt) {
  NodeOptions options = with("");
  options.transport = TransportChoice::automatic;
  const auto said = [&] {
    const Node node = Node::open(options).value();
    eventually([&] { return !warnings().empty(); });
    return take_warnings();
  };
  setenv("SFT_DAEMON", "/nowhere/sftd", 1);
  EXPECT_THAT(said(),
              EndsWith("shared memory: /nowhere/sftd could not be started: No such file or directory; "
                       "the environment variable SFT_DAEMON names it"));
  options.shm.daemon_path = "/elsewhere/sftd";
  EXPECT_THAT(said(),
              EndsWith("shared memory: /elsewhere/sftd could not be started: No such file or directory; "
                       "NodeOptions::shm.daemon_path names it"));
  unsetenv("SFT_DAEMON");
}

TEST_F(ConfigurationTest, ThatForbidsToStartAnSftdLeavesTheStatusSayingThatNoneIsThere) {
  NodeOptions options = with("");
  options.transport = TransportChoice::automatic;
  options.shm.start_daemon = false;
  const Node node = Node::open(options).value();
  EXPECT_TRUE(eventually([&] { return node.status().lacks_daemon; }));
  EXPECT_FALSE(node.status().shm_ready);
  options.shm.start_daemon = true;
  options.shm.daemon_idle_exit = std::chrono::seconds(1);
  const Node other = Node::open(options).value();
  EXPECT_TRUE(eventually([&] { return node.status().shm_ready && !node.status().lacks_daemon; }));
}

std::string why_not(const NodeStatus& status, const std::string& name) {
  const auto found = std::ranges::find(status.quick_paths, name, &NodeStatus::QuickPath::name);
  return found == status.quick_paths.end() ? "not told" : found->why_not;
}

TEST_F(ConfigurationTest, ThatWantsPlainSocketsGetsNoIoUringAndTheStatusSaysSo) {
  NodeOptions options = with("");
  const NodeStatus usual = Node::open(options).value().status();
  EXPECT_EQ(usual.io_uring_in_use, usual.udp.starts_with("io_uring with")) << usual.udp;
  options.udp.use_io_uring = false;
  const NodeStatus plain = Node::open(options).value().status();
  EXPECT_FALSE(plain.io_uring_in_use) << plain.udp;
  EXPECT_EQ(why_not(plain, "io_uring"), "the node asks for plain sockets");
}

TEST_F(ConfigurationTest, LeavesNoQuickPathOutOfTheStatus) {
  NodeOptions options = with("");
  for (const TransportChoice choice : {TransportChoice::automatic, TransportChoice::shm}) {
    options.transport = choice;
    const NodeStatus status = Node::open(options).value().status();
    EXPECT_EQ(status.quick_paths.size(), 4U);
    for (const char* name : {"io_uring", "GSO", "GRO", "huge pages"}) {
      EXPECT_NE(why_not(status, name), "not told") << name;
      if (choice != TransportChoice::shm) continue;
      EXPECT_EQ(why_not(status, name), "the node rules UDP out") << name;
    }
  }
}

TEST_F(ConfigurationTest, OfTheEnvironmentIsReadUnlessTheProgramHasOne) {
  setenv("CYCLONEDDS_URI", "<SharedMemory><Enable>true</></>", 1);
  NodeOptions options = with("");
  EXPECT_EQ(Node::open(options).value().status().discovery,
            "by multicast on lo; no network yet: other hosts are looked for as soon as an interface is up");
  options.cyclonedds_config.reset();
  ++*options.domain;
  EXPECT_THAT(Node::open(options).value().status().discovery, HasSubstr("SharedMemory/Enable"));
  unsetenv("CYCLONEDDS_URI");
}

TEST_F(ConfigurationTest, InAFileThatIsNotThereIsAnErrorThatNamesIt) {
  EXPECT_THAT(error_of(with("file:///nowhere/cyclone.xml")), HasSubstr("'file:///nowhere/cyclone.xml'"));
}

TEST_F(ConfigurationTest, ThatCycloneDoesNotKnowIsAnErrorInItsWords) {
  EXPECT_THAT(error_of(with("<General><Colour>red</></>")), HasSubstr("Colour: unknown element"));
}

TEST_F(ConfigurationTest, OfInterfacesThatAreNotThereIsSaidInTheLogAndTheStatus) {
  NodeOptions options = with("");
  options.discovery.interfaces = {"eth9"};
  const Node node = Node::open(options).value();
  EXPECT_TRUE(is_warned_of("eth9 is not there")) << warnings();
  EXPECT_THAT(node.status().discovery, HasSubstr("eth9 is not there"));
  EXPECT_EQ(node.status().discovery_warnings, std::vector<std::string>{"eth9 is not there"});
  EXPECT_TRUE(node.status().waits_for_network);
}

TEST_F(ConfigurationTest, OfPeersThatHaveNoAddressIsSaidToNameNobody) {
  if (std::system("ip link add near type veth peer name far && ip address add 10.9.0.1/24 dev near && "
                  "ip link set near up && ip link set far up") != 0)
    GTEST_SKIP() << "no pair of virtual network devices can be made here";
  NodeOptions options = with("");
  options.discovery.peers = {"nobody.invalid"};
  const Node node = Node::open(options).value();
  EXPECT_TRUE(is_warned_of("the peer 'nobody.invalid'")) << warnings();
  EXPECT_THAT(node.status().discovery_warnings, ElementsAre(HasSubstr("the peer 'nobody.invalid'")));
}

/// A node that is never destroyed, because its threads cannot be woken and ended once its descriptors are
/// closed.
struct NodeForGood {
  std::mutex mutex;
  std::string warnings;
  std::optional<Node> node;

  explicit NodeForGood(NodeOptions options) {
    options.log = [this](LogLevel level, std::string_view text) {
      const std::scoped_lock lock(mutex);
      if (level == LogLevel::warning) warnings += text;
    };
    node = Node::open(options).value();
  }
  std::string logged() {
    const std::scoped_lock lock(mutex);
    return warnings;
  }
};

/// Returns true if the threads of this process use less than a fifth of a core for 300 ms.
bool is_idle() {
  const auto taken = [] {
    timespec time{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
  };
  const auto before = taken();
  Pace(300ms).await_turn();
  return taken() - before < 60ms;
}

TEST_F(ConfigurationTest, WarnsOnceOfAProgramThatClosesAllDescriptorsAndKeepsNoThreadBusy) {
  static NodeForGood* const kept = new NodeForGood(with(""));
  // A reliable pair, which gives the threads of UDP work to do.
  static auto* const publisher = new Publisher<PointCloud2>(
      kept->node->publisher<PointCloud2>("points", {.reliability = reliable}).value());
  static auto* const subscriber = new Subscriber<PointCloud2>(
      kept->node->subscriber<PointCloud2>("points", {.reliability = reliable}).value());
  ASSERT_TRUE(publisher->wait_for_subscribers(1, 10s));
  ASSERT_EQ(publisher->publish({.height = 1}), PublishStatus::ok);
  ASSERT_TRUE(subscriber->wait(10s));
  const std::string text = "the program has closed the sockets of its node";
  const auto receives = [] { return names_of_threads().contains("recv"); };
  EXPECT_TRUE(eventually(receives));
  closefrom(3);
  EXPECT_TRUE(eventually([&] { return kept->logged().find(text) != std::string::npos; }));
  EXPECT_THAT(kept->node->status().discovery, HasSubstr(text));
  EXPECT_TRUE(eventually([&] { return !receives(); }));
  const std::string logged = kept->logged();
  EXPECT_EQ(logged.find(text), logged.rfind(text));
  EXPECT_TRUE(eventually(is_idle));
}

TEST_F(ConfigurationTest, FilesThatAProgramOpensAfterItClosedAllDescriptorsStayItsOwn) {
  static NodeForGood* const kept = new NodeForGood(with(""));
  const std::size_t descriptors = std::distance(std::filesystem::directory_iterator("/proc/self/fd"), {});
  closefrom(3);
  std::vector<int> own;
  for (std::size_t i = 0; i < 2 * descriptors; ++i) own.push_back(open("/dev/null", O_RDONLY));
  EXPECT_TRUE(eventually(
      [&] { return kept->logged().find("has closed the sockets of its node") != std::string::npos; }));
  struct stat null_device {};
  ASSERT_EQ(stat("/dev/null", &null_device), 0);
  for (const int one : own) {
    struct stat file {};
    EXPECT_EQ(fstat(one, &file), 0) << one;
    EXPECT_EQ(file.st_rdev, null_device.st_rdev) << one;
  }
}

TEST_F(ConfigurationTest, MayBeAnotherOneForEachNodeOfAProcess) {
  const Node first = Node::open(with("")).value();
  EXPECT_TRUE(Node::open(with("")));
  NodeOptions other = with("");
  other.discovery.peers = {"10.0.0.7"};
  const Node second = Node::open(other).value();
  EXPECT_THAT(second.status().discovery, HasSubstr("10.0.0.7"));
  EXPECT_THAT(first.status().discovery, testing::Not(HasSubstr("10.0.0.7")));
}

TEST_F(ConfigurationTest, OfTheDomainIsANumberFrom0To232) {
  NodeOptions options = with("");
  options.domain.reset();
  for (const char* domain : {"233", "-1", "one"}) {
    setenv("ROS_DOMAIN_ID", domain, 1);
    EXPECT_THAT(error_of(options), HasSubstr("ROS_DOMAIN_ID is '" + std::string(domain) + "'"));
  }
  setenv("ROS_DOMAIN_ID", "232", 1);
  EXPECT_TRUE(Node::open(options));
}

}  // namespace
}  // namespace sft::test
