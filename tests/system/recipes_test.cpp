// The recipes of docs/guide.md for timers, services, parameters and exchange with DDS nodes work as the
// guide says.
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdio>
#include <geometry_msgs/msg/Twist.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <span>
#include <std_msgs/msg/Float64.hpp>
#include <std_srvs/srv/SetBool.hpp>
#include <string>
#include <thread>

#include "sft/sft.h"
#include "tests/support/eventually.h"

using geometry_msgs::msg::Twist;
using sensor_msgs::msg::PointCloud2;
using std_msgs::msg::Float64;
using std_srvs::srv::SetBool;

// These functions are printed in docs/guide.md.
void count_clouds(sft::Node& node);
void print_commands(sft::Node& node);
sft::Service<SetBool> serve_lights(sft::Node& node);
std::string switch_lights(sft::Client<SetBool>& lights, bool on);
sft::Publisher<Float64> exposure_parameter(sft::Node& node);
sft::Subscriber<Float64> follow_exposure(sft::Node& node, std::atomic<double>& exposure_ms);
sft::Result<sft::PublishStatus> pass_on(sft::Publisher<PointCloud2>& points,
                                        std::span<const std::byte> serialized);

namespace {

using namespace std::chrono_literals;

/// Makes standard output line-buffered, so that each printed line arrives at once. Newer C libraries refuse
/// to change the buffering after the first output, so it is changed at the start.
[[maybe_unused]] const int line_buffered = std::setvbuf(stdout, nullptr, _IOLBF, BUFSIZ);

class RecipesTest : public testing::Test {
 protected:
  sft::Node node_ = sft::Node::open({.name = "here"}).value();
  sft::Node other_ = sft::Node::open({.name = "there"}).value();
};

/// Redirects standard output as long as this object lives, so that the test can read it line by line.
class PrintedLines {
 public:
  PrintedLines() {
    int ends[2];
    if (pipe(ends) != 0) return;
    std::fflush(stdout);
    before_ = dup(STDOUT_FILENO);
    dup2(ends[1], STDOUT_FILENO);
    close(ends[1]);
    printed_ = fdopen(ends[0], "r");
  }
  ~PrintedLines() {
    restore();
    std::fclose(printed_);
  }
  PrintedLines(const PrintedLines&) = delete;
  PrintedLines& operator=(const PrintedLines&) = delete;

  /// Waits for the next line and returns it.
  std::string next() {
    std::string line;
    for (int c = std::fgetc(printed_); c != EOF && c != '\n'; c = std::fgetc(printed_)) {
      line += static_cast<char>(c);
    }
    return line;
  }

 private:
  void restore() const {
    std::fflush(stdout);
    dup2(before_, STDOUT_FILENO);
    close(before_);
  }

  int before_ = -1;
  FILE* printed_ = nullptr;
};

TEST_F(RecipesTest, AnEventLoopCountsCloudsUntilItIsInterrupted) {
  int clouds = 0;
  {
    PrintedLines printed;
    std::thread loop([&] { count_clouds(node_); });
    auto points = other_.publisher<PointCloud2>("points").value();
    const bool served = points.wait_for_subscribers(1, 10s);
    for (int i = 0; served && i < 3; ++i) points.publish(PointCloud2{});
    while (served && clouds < 3) clouds += std::stoi(printed.next());
    kill(getpid(), SIGINT);
    loop.join();
  }
  EXPECT_EQ(clouds, 3);
}

TEST_F(RecipesTest, AProgramThatWaitsEndsAtCtrlC) {
  std::string line;
  {
    PrintedLines printed;
    std::thread loop([&] { print_commands(node_); });
    auto commands = other_.publisher<Twist>("cmd_vel").value();
    const bool served = commands.wait_for_subscribers(1, 10s);
    Twist command;
    command.linear.x = 0.5;
    if (served) commands.publish(command);
    if (served) line = printed.next();
    kill(getpid(), SIGINT);
    loop.join();
  }
  EXPECT_EQ(line, "0.5 m/s");
  EXPECT_TRUE(node_.is_interrupted());
}

TEST_F(RecipesTest, AServiceAnswersItsClient) {
  auto lights = sft::Client<SetBool>::open(node_, "lights").value();
  EXPECT_EQ(switch_lights(lights, true), "") << "nobody serves yet";
  const auto server = serve_lights(other_);
  ASSERT_TRUE(sft::test::eventually([&] { return lights.is_available(); }));
  EXPECT_EQ(switch_lights(lights, true), "on");
  EXPECT_EQ(switch_lights(lights, false), "off");
}

TEST_F(RecipesTest, AParameterIsKnownToWhoeverComesLaterAndFollowed) {
  auto parameter = exposure_parameter(node_);
  parameter.publish({.data = 8.5});
  std::atomic<double> exposure_ms = 0;
  const auto follower = follow_exposure(other_, exposure_ms);
  EXPECT_TRUE(sft::test::eventually([&] { return exposure_ms == 8.5; }));
  parameter.publish({.data = 2});
  EXPECT_TRUE(sft::test::eventually([&] { return exposure_ms == 2; }));
}

TEST_F(RecipesTest, ABridgePassesOnWhatIsEncodedAlready) {
  auto source = node_.publisher<PointCloud2>("ros/points").value();
  auto received = node_.subscriber<PointCloud2>("ros/points").value();
  auto passed_on = other_.publisher<PointCloud2>("points").value();
  auto subscriber = node_.subscriber<PointCloud2>("points").value();
  ASSERT_TRUE(source.wait_for_subscribers(1, 10s));
  ASSERT_TRUE(passed_on.wait_for_subscribers(1, 10s));
  source.publish({.width = 1024});
  ASSERT_TRUE(received.wait(10s));
  const auto sample = received.take();
  const auto result = pass_on(passed_on, sample.cdr());
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_EQ(*result, sft::PublishStatus::ok);
  ASSERT_TRUE(subscriber.wait(10s));
  const auto arrived = subscriber.take();
  EXPECT_EQ(arrived->width(), 1024U);
}

}  // namespace
