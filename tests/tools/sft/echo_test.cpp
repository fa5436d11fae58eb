// The verb echo in all formats.
#include <diagnostic_msgs/msg/DiagnosticArray.hpp>
#include <nav_msgs/msg/Odometry.hpp>
#include <sensor_msgs/msg/LaserScan.hpp>

#include "tests/tools/sft/tool_fixture.h"

namespace sft::test {
namespace {

using diagnostic_msgs::msg::DiagnosticArray;
using nav_msgs::msg::Odometry;
using sensor_msgs::msg::LaserScan;

constexpr const char* some_fields = "header.frame_id, width, fields[].name";

class EchoTest : public ToolTest {
 protected:
  /// Publishes a message and returns its publisher. While the publisher exists, each late subscriber gets the
  /// message.
  template <class T>
  static Publisher<T> keep(Node& node, const char* topic, const T& message) {
    auto publisher = node.publisher<T>(topic, {.durability = transient_local}).value();
    publisher.publish(message);
    return publisher;
  }
  static Json echoed(const char* topic) {
    const Ended ended = run_tool({"echo", topic, "--once", "--json"});
    EXPECT_EQ(ended.code, 0) << ended.err;
    return Json::parse(ended.out);
  }
};

TEST_F(EchoTest, JsonIsWhatWasPublishedWithNestedArraysAndStrings) {
  DiagnosticArray array;
  array.header.frame_id = "base \"link\"\n\xc3\xa9";
  array.status.resize(2);
  array.status[0].name = "motor";
  array.status[0].values.resize(2);
  array.status[0].values[0].key = "current";
  array.status[0].values[0].value = "1.5 A";
  array.status[0].values[1].key = "";
  array.status[1].message = "ok";
  const auto publisher = keep(robot, "diagnostics", array);
  const Json json = echoed("diagnostics");
  EXPECT_EQ(json["header"]["frame_id"], array.header.frame_id);
  ASSERT_EQ(json["status"].size(), 2U);
  EXPECT_EQ(json["status"][0]["values"],
            Json::parse(R"([{"key": "current", "value": "1.5 A"}, {"key": "", "value": ""}])"));
  EXPECT_EQ(json["status"][1]["message"], "ok");
  EXPECT_EQ(json["status"][1]["values"], Json::array());
}

TEST_F(EchoTest, JsonIsWhatWasPublishedWithNumbersOfAllKinds) {
  Odometry odometry;
  odometry.pose.pose.position.x = -0.1;
  odometry.pose.covariance[35] = 1e-300;
  odometry.twist.covariance[0] = 4;
  const auto publisher = keep(robot, "odom", odometry);
  const Json json = echoed("odom");
  EXPECT_EQ(json["pose"]["pose"]["position"]["x"], -0.1);
  EXPECT_EQ(json["pose"]["covariance"].get<std::vector<double>>(),
            std::vector<double>(odometry.pose.covariance.begin(), odometry.pose.covariance.end()));
  LaserScan scan;
  scan.angle_min = 0.1F;
  scan.ranges = {1.5F, 2.25F, 3e10F};
  const auto scans = keep(robot, "scan", scan);
  EXPECT_EQ(echoed("scan")["angle_min"], 0.1);
  EXPECT_EQ(echoed("scan")["ranges"].get<std::vector<float>>(), scan.ranges);
}

TEST_F(EchoTest, OnlyTheseFieldsAreAskedForAndPrintedInEachFormat) {
  auto points = robot.publisher<PointCloud2>("points").value();
  const Publishing publishing(points, cloud());
  const Ended yaml = run_tool({"echo", "points", "--once", "--fields", some_fields});
  EXPECT_EQ(yaml.code, 0) << yaml.err;
  EXPECT_EQ(
      yaml.out,
      "header:\n  frame_id: \"lidar, \\\"front\\\"\"\nwidth: 1024\nfields:\n- name: x\n- name: \"y\"\n---\n");
  EXPECT_EQ(run_tool({"echo", "points", "--once", "--json", "--fields", some_fields}).out,
            R"({"header":{"frame_id":"lidar, \"front\""},"width":1024,"fields":[{"name":"x"},{"name":"y"}]})"
            "\n");
  EXPECT_EQ(run_tool({"echo", "points", "--count", "2", "--csv", "--fields", some_fields}).out,
            "header.frame_id,width,fields\n"
            "\"lidar, \"\"front\"\"\",1024,\"[{\"\"name\"\":\"\"x\"\"},{\"\"name\"\":\"\"y\"\"}]\"\n"
            "\"lidar, \"\"front\"\"\",1024,\"[{\"\"name\"\":\"\"x\"\"},{\"\"name\"\":\"\"y\"\"}]\"\n");
}

TEST_F(EchoTest, ThePublisherIsAskedForNoOtherFields) {
  auto points = robot.publisher<PointCloud2>("points").value();
  ToolProcess echo({"echo", "points", "--fields", "header.stamp, width"});
  ASSERT_TRUE(eventually([&] { return points.status().readers.size() == 1; }));
  EXPECT_EQ(points.status().readers[0].mask, FieldMask(F::header.stamp | F::width));
}

TEST_F(EchoTest, PartsOfFieldsAreMessagesOfTheSameType) {
  auto scans = robot.publisher<LaserScan>("scan").value();
  LaserScan scan;
  scan.angle_increment = 0.5F;
  scan.ranges = {1, 2, 3, 4, 5};
  const Publishing publishing(scans, scan);
  const Ended some = run_tool({"echo", "scan", "--once", "--json", "--fields", "ranges[1::2]"});
  EXPECT_EQ(
      some.out,
      R"({"angle_min":0.5,"angle_max":1.5,"angle_increment":1.0,"time_increment":0.0,"ranges":[2.0,4.0]})"
      "\n");
  EXPECT_EQ(run_tool({"echo", "scan", "--fields", "ranges[rows 1]"}).code, 2);
}

TEST_F(EchoTest, AChannelThatTheCloudLacksIsNamedOnce) {
  auto points = robot.publisher<PointCloud2>("points").value();
  PointCloud2 two_channels{.height = 1, .width = 4, .point_step = 8, .row_step = 32};
  two_channels.fields.resize(2);
  two_channels.fields[0] = {.name = "x", .offset = 0, .datatype = 7, .count = 1};
  two_channels.fields[1] = {.name = "y", .offset = 4, .datatype = 7, .count = 1};
  two_channels.data.resize(32);
  const Publishing publishing(points, two_channels);
  const Ended some = run_tool({"echo", "points", "--count", "3", "--fields", "data{x,w}"});
  EXPECT_EQ(some.code, 0);
  EXPECT_EQ(
      some.err,
      "sft: The cloud has no channel 'w'; 'sft echo points --fields fields[].name --once' lists those it "
      "has.\n");
  EXPECT_EQ(run_tool({"echo", "points", "--once", "--fields", "data{x,y}"}).err, "");
}

TEST_F(EchoTest, SamplesThatFulfilConditionsArePrinted) {
  auto scans = robot.publisher<LaserScan>("scan").value();
  LaserScan scan;
  scan.angle_increment = 0.5F;
  const Publishing publishing(scans, scan);
  const Ended some =
      run_tool({"echo", "scan", "--once", "--json", "--fields", "angle_increment @ angle_increment > 0"});
  EXPECT_EQ(some.out, "{\"angle_increment\":0.5}\n");
  EXPECT_EQ(run_tool({"echo", "scan", "--fields", "ranges @ every 0th"}).code, 2);
}

TEST_F(EchoTest, SamplesComeByEitherOfTwoSelections) {
  auto scans = robot.publisher<LaserScan>("scan").value();
  LaserScan scan;
  scan.angle_increment = 0.5F;
  scan.range_min = 0.25F;
  const Publishing publishing(scans, scan);
  ToolProcess echo({"echo", "scan", "--fields", "angle_increment", "--fields", "range_min @ every 2nd"});
  EXPECT_TRUE(echo.prints("# selection 0\nangle_increment: 0.5\n---\n")) << echo.out();
  EXPECT_TRUE(echo.prints("# selection 1\nrange_min: 0.25\n---\n")) << echo.out();
  ToolProcess table({"echo", "scan", "--csv", "--fields", "ranges", "--fields", "range_min"});
  EXPECT_TRUE(table.prints("range_min,ranges\n")) << table.out();
  EXPECT_TRUE(table.prints("\n0.25,\n")) << table.out();
  EXPECT_EQ(run_tool({"echo", "scan", "--fields", "ranges", "--fields", "ragnes"}).code, 2);
}

TEST_F(EchoTest, WhatEveryPublisherOffersIsAskedFor) {
  Node camera = open("camera");
  auto live = camera.publisher<PointCloud2>("points").value();
  const auto retained = keep(robot, "points", cloud());
  PointCloud2 narrow = cloud();
  narrow.width = 7;
  const Publishing publishing(live, narrow);
  EXPECT_EQ(run_tool({"echo", "points", "--once", "--fields", "width"}).out, "width: 7\n---\n")
      << "only one of them retains samples";
}

TEST_F(EchoTest, LossesOfEachSelectionAreTold) {
  auto scans = robot.publisher<LaserScan>("scan").value();
  LaserScan scan;
  ToolProcess echo(
      {"echo", "scan", "--fields", "angle_min @ angle_min > 0", "--fields", "scan_time, range_min"});
  {
    const Publishing publishing(scans, scan);
    ASSERT_TRUE(echo.prints("scan_time: 0.0\n"));
  }
  echo.send(SIGSTOP);
  for (int i = 0; i < 100'000; ++i) scans.publish(scan);
  echo.send(SIGCONT);
  scan.scan_time = 0.5F;
  const Publishing publishing(scans, scan);
  ASSERT_TRUE(echo.prints("scan_time: 0.5\n"));
  echo.send(SIGINT);
  const Ended ended = echo.end();
  EXPECT_THAT(ended.err, HasSubstr(" samples of 'scan' were lost")) << ended.err;
}

TEST_F(EchoTest, FromSharedMemoryToo) {
  Node camera = open("camera", TransportChoice::shm);
  auto points = camera.publisher<PointCloud2>("images").value();
  const Publishing publishing(points, cloud());
  ASSERT_TRUE(eventually([&] { return camera.status().shm_ready; }));
  EXPECT_EQ(run_tool({"echo", "images", "--once", "--json", "--fields", "width, height"}).out,
            "{\"height\":1,\"width\":1024}\n");
}

TEST_F(EchoTest, LongArraysAreShortenedOnTerminalsOnly) {
  auto points = robot.publisher<PointCloud2>("points").value();
  const Publishing publishing(points, cloud());
  ToolProcess shortened({"echo", "points", "--once", "--fields", "data"}, ToolProcess::On::terminal);
  EXPECT_TRUE(shortened.prints("... 984 more")) << shortened.out();
  ToolProcess full({"echo", "points", "--once", "--fields", "data", "--full"}, ToolProcess::On::terminal);
  EXPECT_TRUE(full.prints("---")) << full.out();
  EXPECT_EQ(full.out().find("more"), std::string::npos);
  EXPECT_GT(run_tool({"echo", "points", "--once", "--fields", "data"}).out.size(), 3000U);
}

TEST_F(EchoTest, AnUnknownFieldIsOneSentenceWithTheNearestOne) {
  auto points = robot.publisher<PointCloud2>("points").value();
  const Ended ended = run_tool({"echo", "points", "--fields", "hieght"});
  EXPECT_EQ(ended.code, 2);
  EXPECT_EQ(ended.err,
            "sft: column 1: sensor_msgs::msg::PointCloud2 has no field 'hieght'; did you mean 'height'?\n");
}

TEST_F(EchoTest, WhereNothingComesInTimeItSaysSo) {
  auto points = robot.publisher<PointCloud2>("points").value();
  const Ended ended = run_tool({"echo", "points", "--once", "--timeout", "0.5"});
  EXPECT_EQ(ended.code, 1);
  EXPECT_THAT(ended.err, HasSubstr("No sample of 'points' came within 0.5 s"));
}

TEST_F(EchoTest, ItEndsWhenNobodyReadsItsOutput) {
  auto points = robot.publisher<PointCloud2>("points").value();
  const Publishing publishing(points, cloud());
  ToolProcess echo({"echo", "points", "--fields", "width"});
  ASSERT_TRUE(echo.prints("width: 1024"));
  echo.close_output();
  EXPECT_EQ(echo.end().code, 0);
  EXPECT_TRUE(eventually([&] { return points.status().readers.empty(); }));
}

}  // namespace
}  // namespace sft::test
