// Typical mistakes of programs that set no option for the log. The text on standard error names the
// mistake, and says what to do or what differs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <sft/sft.h>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <sensor_msgs/msg/LaserScan.hpp>
#include <std_srvs/srv/SetBool.hpp>
#include <string>
#include <vector>

#include "tests/support/isolated_host.h"
#include "tests/system/fixture.h"

namespace sft::test {
namespace {

using sensor_msgs::msg::LaserScan;
using ::testing::HasSubstr;

class FirstWords : public ::testing::Test {
 protected:
  void SetUp() override {
    unsetenv("SFT_LOG");
    begin_ = std::chrono::steady_clock::now();
    printed_ = memfd_create("stderr", MFD_CLOEXEC);
    before_ = dup(STDERR_FILENO);
    ASSERT_GE(dup2(printed_, STDERR_FILENO), 0);
  }
  void TearDown() override {
    dup2(before_, STDERR_FILENO);
    close(before_);
    close(printed_);
  }
  std::string printed() const {
    std::string text(static_cast<std::size_t>(lseek(printed_, 0, SEEK_END)), '\0');
    const ssize_t bytes = pread(printed_, text.data(), text.size(), 0);
    text.resize(static_cast<std::size_t>(std::max<ssize_t>(bytes, 0)));
    return text;
  }
  /// Expects all given texts in the log, and prints how long it took.
  void expect_says(const std::vector<std::string>& texts) const {
    for (const std::string& text : texts)
      EXPECT_TRUE(eventually([&] { return printed().find(text) != std::string::npos; })) << text << "\nin\n"
                                                                                         << printed();
    EXPECT_EQ(printed().find("[sft] "), 0U);
    const std::chrono::duration<double> time = std::chrono::steady_clock::now() - begin_;
    std::printf("first words after %.1f s: %s\n", time.count(),
                testing::UnitTest::GetInstance()->current_test_info()->name());
  }
  static Node open(const std::string& name = "robot") {
    NodeOptions options{.name = name};
    options.shm.daemon_idle_exit = 5s;
    return Node::open(options).value();
  }
  static Publisher<PointCloud2> publisher(Node& node, const PublisherOptions& options = {}) {
    return node.publisher<PointCloud2>("points", options).value();
  }
  static Subscriber<PointCloud2> subscriber(Node& node, const SubscriberOptions& options = {}) {
    return node.subscriber<PointCloud2>("points", options).value();
  }

 private:
  std::chrono::steady_clock::time_point begin_;
  int printed_ = -1, before_ = -1;
};

TEST_F(FirstWords, OfASubscriberThatWantsMoreReliabilityThanThereIs) {
  Node node = open();
  const auto pub = publisher(node);
  const auto sub = subscriber(node, {.reliability = reliable});
  expect_says(
      {"[sft] warning: robot: topic 'points', node 'robot': incompatible QoS: ", "reliable", "best_effort"});
}

TEST_F(FirstWords, OfASubscriberThatWantsSamplesFromBefore) {
  Node node = open();
  const auto pub = publisher(node);
  const auto sub = subscriber(node, {.durability = transient_local});
  expect_says({"incompatible QoS: ", "transient_local", "volatile"});
}

TEST_F(FirstWords, OfTwoTypesOnOneTopic) {
  Node node = open();
  const auto pub = publisher(node);
  const auto sub = node.subscriber<LaserScan>("points").value();
  expect_says({"sensor_msgs::msg::PointCloud2", "sensor_msgs::msg::LaserScan"});
}

TEST_F(FirstWords, OfAPublisherAndASubscriberWithNoPathForBoth) {
  Node node = open();
  const auto pub = publisher(node, {.transport = TransportChoice::shm});
  const auto sub = subscriber(node, {.transport = TransportChoice::udp});
  expect_says({"topic 'points', node 'robot': no path"});
}

TEST_F(FirstWords, OfAMessageThatIsTooLarge) {
  Node node = open();
  auto pub = publisher(node);
  PointCloud2 image;
  image.data.resize(70'000'000);
  EXPECT_EQ(pub.publish(image), PublishStatus::invalid);
  expect_says(
      {"robot: a message is not sent: topic 'points': the message has ", "'data'", "which no option raises"});
}

TEST_F(FirstWords, OfAStringWithANul) {
  Node node = open();
  auto pub = publisher(node);
  PointCloud2 cloud;
  cloud.header.frame_id = std::string("a\0b", 3);
  EXPECT_EQ(pub.publish(cloud), PublishStatus::invalid);
  expect_says({"'header.frame_id' has a NUL"});
}

TEST_F(FirstWords, OfASampleThatDoesNotFitSharedMemory) {
  Node node = open();
  ASSERT_TRUE(eventually([&] { return node.status().shm_ready; })) << node.status().shm;
  auto pub = publisher(node);
  const auto sub = subscriber(node);
  const auto in_memory = [&] {
    const PublisherStatus status = pub.status();
    return !status.readers.empty() && status.readers[0].served &&
           status.readers[0].transport == TransportKind::shm;
  };
  ASSERT_TRUE(eventually(in_memory));
  PointCloud2 image;
  image.data.resize(25'000'000);
  pub.publish(image);
  expect_says({"topic 'points': samples diverted"});
}

TEST_F(FirstWords, OfASubscriberThatHoldsTooManySamples) {
  Node node = open();
  ASSERT_TRUE(eventually([&] { return node.status().shm_ready; })) << node.status().shm;
  auto pub = publisher(node, {.transport = TransportChoice::shm});
  auto sub = subscriber(node, {.transport = TransportChoice::shm, .max_held = 2});
  ASSERT_TRUE(pub.wait_for_subscribers(1, hang_timeout));
  std::vector<Sample<PointCloud2>> held;
  EXPECT_TRUE(eventually([&] {
    pub.publish({.height = 1});
    if (auto sample = sub.take()) held.push_back(std::move(sample));
    return sub.status().held_too_many > 0;
  }));
  expect_says({"topic 'points': too many samples held: no more of a publisher can be taken until"});
}

TEST_F(FirstWords, OfAReliableSubscriberWithAQueueThatSharedMemoryDoesNotHave) {
  Node node = open();
  const auto sub = subscriber(node, {.reliability = reliable, .depth = 1000});
  expect_says({"topic 'points': SubscriberOptions::depth is 1000, but shared memory keeps 256"});
}

TEST_F(FirstWords, OfACallbackThatHoldsUpAnotherOne) {
  Node node = open();
  NodeOptions options{.name = "source", .transport = TransportChoice::shm};
  Node source = Node::open(options).value();
  std::atomic<bool> goes_on{false}, is_called{false};
  auto camera = source.publisher<PointCloud2>("camera").value();
  auto halt = source.publisher<PointCloud2>("stop").value();
  const auto detect = node.subscriber<PointCloud2>("camera",
                                                   [&](const auto&) {
                                                     is_called = true;
                                                     EXPECT_TRUE(eventually([&] { return goes_on.load(); }));
                                                   })
                          .value();
  const auto stop = node.subscriber<PointCloud2>("stop", [](const auto&) {}).value();
  ASSERT_TRUE(camera.wait_for_subscribers(1, hang_timeout) && halt.wait_for_subscribers(1, hang_timeout));
  camera.publish({.height = 1});
  ASSERT_TRUE(eventually([&] { return is_called.load(); }));
  halt.publish({.height = 1});
  expect_says({"robot: topic 'stop': a sample has waited for its callback", "that of topic 'camera'"});
  goes_on = true;
}

TEST_F(FirstWords, OfATopicThatIsNotPublishedWhileASimilarOneIs) {
  Node node = open();
  Node lidar = Node::open({.name = "lidar"}).value();
  const auto points = lidar.publisher<PointCloud2>("lidar/points").value();
  const auto misspelt = node.subscriber<PointCloud2>("lidar/pionts").value();
  expect_says(
      {"topic 'lidar/pionts': no publisher of it was seen; did you mean 'lidar/points', which node 'lidar'"});
}

TEST_F(FirstWords, OfAServiceWhoseNameIsMisspelt) {
  Node node = open();
  Node robot = Node::open({.name = "base"}).value();
  using std_srvs::srv::SetBool;
  const auto answer = [](const SetBool::Request&) { return SetBool::Response{}; };
  const auto service = Service<SetBool>::open(robot, "lights", answer).value();
  const auto client = Client<SetBool>::open(node, "lihgts").value();
  expect_says(
      {"topic 'lihgts/reply': no publisher of it was seen; did you mean 'lights/reply', which node 'base'"});
}

TEST_F(FirstWords, OfARuleForNamesThatFitsNothing) {
  NodeOptions options{.name = "robot", .remap = {"scna:=front/scan"}};
  Node node = Node::open(options).value();
  const auto scan = node.subscriber<LaserScan>("scan").value();
  expect_says({"'scna:=front/scan'"});
}

TEST_F(FirstWords, OfSimulatedTimeThatNobodyPublishes) {
  NodeOptions options{.name = "robot", .use_sim_time = true};
  const Node node = Node::open(options).value();
  expect_says({"use_sim_time: there is no publisher of the topic 'clock'"});
}

TEST_F(FirstWords, OfAnInterfaceThatIsNotThere) {
  NodeOptions options{.name = "robot"};
  options.discovery.interfaces = {"eth9"};
  const Node node = Node::open(options).value();
  expect_says({"[sft] warning: robot: discovery: eth9 is not there"});
}

TEST_F(FirstWords, OfALevelOfTheLogThatThereIsNot) {
  setenv("SFT_LOG", "verbose", 1);
  const Node node = open();
  expect_says({"the environment variable SFT_LOG is 'verbose', which is none of off, error"});
  unsetenv("SFT_LOG");
}

TEST_F(FirstWords, AreNotWrittenWhereTheEnvironmentSaysSo) {
  setenv("SFT_LOG", "off", 1);
  {
    Node node = open();
    auto pub = publisher(node);
    const auto sub = subscriber(node, {.reliability = reliable});
    ASSERT_TRUE(eventually([&] { return !pub.status().readers.empty(); }));
  }
  EXPECT_EQ(printed(), "");
  unsetenv("SFT_LOG");
}

TEST_F(FirstWords, AreNoneOfAProgramThatIsRight) {
  {
    Node node = open();
    auto pub = publisher(node, {.reliability = reliable});
    auto sub = subscriber(node, {.reliability = reliable});
    ASSERT_TRUE(pub.wait_for_subscribers(1, hang_timeout));
    pub.publish({.height = 1});
    EXPECT_TRUE(sub.wait(hang_timeout));
  }
  EXPECT_EQ(printed(), "");
}

}  // namespace
}  // namespace sft::test
