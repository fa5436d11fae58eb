// The measurements of the verbs hz, bw and delay.
#include <sstream>
#include <tf2_msgs/msg/TFMessage.hpp>

#include "tests/tools/sft/tool_fixture.h"

namespace sft::test {
namespace {

class MeasureTest : public ToolTest {
 protected:
  /// Runs the command. Returns the last line that it prints, as JSON.
  static Json measured(std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {"--json", "--for", "3.5"});
    const Ended ended = run_tool(std::move(arguments));
    EXPECT_EQ(ended.code, 0) << ended.err;
    const std::size_t last = ended.out.rfind('\n', ended.out.size() - 2);
    return Json::parse(ended.out.substr(last == std::string::npos ? 0 : last + 1));
  }

  Publisher<PointCloud2> points = robot.publisher<PointCloud2>("points").value();
};

TEST_F(MeasureTest, HzCountsSamplesWithoutAskingForAnyField) {
  PointCloud2 large = cloud();
  large.data.resize(1'000'000);
  const Publishing publishing(points, large, 20ms);
  const Json json = measured({"hz", "points"});
  EXPECT_NEAR(json["rate_hz"].get<double>(), 50, 5);
  EXPECT_NEAR(json["period_s"]["mean"].get<double>(), 0.02, 0.002);
  EXPECT_EQ(json["lost"], 0);
  EXPECT_LT(points.status().bytes_sent, 100U * json["samples"].get<std::uint64_t>());
}

TEST_F(MeasureTest, HzCountsEachSampleAsNewOnce) {
  const Publishing publishing(points, cloud(), 20ms);
  std::istringstream lines(run_tool({"hz", "points", "--json", "--for", "3.5"}).out);
  std::uint64_t new_ones = 0, samples = 0;
  for (std::string line; std::getline(lines, line);) {
    const Json json = Json::parse(line);
    new_ones += json["new"].get<std::uint64_t>();
    samples = json["samples"];
  }
  EXPECT_GT(samples, 0U);
  EXPECT_EQ(new_ones, samples);
}

TEST_F(MeasureTest, HzWatchesSeveralTopicsAndTellsOfThoseThatAreQuiet) {
  auto quiet = robot.publisher<PointCloud2>("quiet").value();
  const Publishing publishing(points, cloud());
  const Ended ended = run_tool({"hz", "points", "/quiet", "--for", "1.5"});
  EXPECT_EQ(ended.code, 1);
  EXPECT_THAT(ended.out, HasSubstr("points: "));
  EXPECT_THAT(ended.out, HasSubstr(" Hz, periods of "));
  EXPECT_THAT(ended.out, HasSubstr("quiet: no sample yet\n"));
}

TEST_F(MeasureTest, BwMeasuresOneWholeSampleASecond) {
  const Publishing publishing(points, cloud(), 20ms);
  const Json json = measured({"bw", "points"});
  const double size = json["sample_bytes"]["mean"].get<double>();
  EXPECT_NEAR(size, 1120, 40);
  EXPECT_NEAR(json["bytes_per_s"].get<double>(), 50 * size, 5 * size);
  EXPECT_LE(json["sample_bytes"]["measured"], 5);
  EXPECT_GT(measured({"bw", "points", "--every"})["sample_bytes"]["measured"], 100);
  EXPECT_EQ(measured({"bw", "points", "--fields", "width, height"})["sample_bytes"]["max"], 12);
}

TEST_F(MeasureTest, DelayIsTheAgeOfTheStamp) {
  const Publishing publishing(points, cloud(), 20ms, true);
  const Json json = measured({"delay", "points"});
  EXPECT_EQ(json["since"], "header.stamp");
  EXPECT_GT(json["delay_s"]["min"], 0);
  EXPECT_LT(json["delay_s"]["mean"], 0.1);
  EXPECT_GT(measured({"delay", "points", "--published"})["samples"], 50);
}

TEST_F(MeasureTest, DelaysThatAreOlderThanTheWindowCountNoMore) {
  ToolProcess delay({"delay", "points", "--window", "1", "--for", "30"});
  {
    const Publishing unstamped(points, cloud(), 20ms);
    ASSERT_TRUE(delay.prints(" so far; not set: ")) << delay.out();
  }
  const Publishing stamped(points, cloud(), 20ms, true);
  EXPECT_TRUE(delay.prints(" so far\n")) << delay.out();
}

TEST_F(MeasureTest, DelaysBelowZeroAreThoseOfClocksThatDiffer) {
  PointCloud2 ahead = cloud();
  ahead.header.stamp =
      time_message<builtin_interfaces::msg::Time>(std::chrono::system_clock::now() + std::chrono::hours(1));
  const Publishing publishing(points, ahead, 20ms);
  ToolProcess delay({"delay", "points", "--for", "30"});
  EXPECT_TRUE(delay.prints("; stamps are in the future: clocks differ\n")) << delay.out();
}

TEST_F(MeasureTest, DelayNeedsAStamp) {
  auto time = robot.publisher<builtin_interfaces::msg::Time>("time").value();
  const Ended ended = run_tool({"delay", "time"});
  EXPECT_EQ(ended.code, 2);
  EXPECT_THAT(ended.err, HasSubstr("builtin_interfaces::msg::Time has no field header.stamp"));
}

TEST_F(MeasureTest, DelayTakesAnyFieldOfTheTypeTime) {
  auto transforms = robot.publisher<tf2_msgs::msg::TFMessage>("tf").value();
  tf2_msgs::msg::TFMessage message;
  message.transforms.resize(2);
  message.transforms[1].header.stamp =
      time_message<builtin_interfaces::msg::Time>(std::chrono::system_clock::now() - 2s);
  const Ticker publishing(
      20ms, [&](std::uint32_t) { transforms.publish(message); }, Keeps::rate);
  const Json json = measured({"delay", "tf", "--field", "transforms[1].header.stamp"});
  EXPECT_EQ(json["since"], "transforms[1].header.stamp");
  EXPECT_GT(json["delay_s"]["min"], 1.9);
  EXPECT_LT(json["delay_s"]["max"], 20);
  EXPECT_EQ(measured({"delay", "tf", "--field", "transforms[0].header.stamp"})["not_set"].get<int>() > 0,
            true);
  EXPECT_GT(measured({"delay", "tf", "--field", "transforms[7].header.stamp"})["absent"], 0);
  const Ended wrong = run_tool({"delay", "tf", "--field", "transforms[0].child_frame_id"});
  EXPECT_EQ(wrong.code, 2);
  EXPECT_THAT(wrong.err, HasSubstr("has no field 'transforms[0].child_frame_id' of the type Time"));
}

}  // namespace
}  // namespace sft::test
