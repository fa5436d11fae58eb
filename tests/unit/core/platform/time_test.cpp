// Conversion of timestamps and durations in messages to std::chrono, and back.
#include "sft/time.h"

#include <gtest/gtest.h>

#include <builtin_interfaces/msg/Duration.hpp>
#include <builtin_interfaces/msg/Time.hpp>
#include <cstdint>
#include <optional>
#include <std_msgs/msg/Header.hpp>

#include "sft/sample.h"
#include "tests/support/encoded.h"

namespace sft {
namespace {

using namespace detail;

using builtin_interfaces::msg::Duration;
using builtin_interfaces::msg::Time;
using std_msgs::msg::Header;
using namespace std::chrono_literals;
using Point = std::chrono::sys_time<std::chrono::nanoseconds>;

TEST(TimeTest, AStampIsAPointInTimeAndComesBack) {
  Time stamp;
  stamp.sec = 1'700'000'000;
  stamp.nanosec = 5;
  EXPECT_EQ(to_time(stamp), Point(1'700'000'000s + 5ns));
  EXPECT_EQ(time_message<Time>(to_time(stamp)), stamp);
  const Point now = std::chrono::system_clock::now();
  EXPECT_EQ(to_time(time_message<Time>(now)), now);
}

TEST(TimeTest, NegativeDurationsHaveNanosecondsThatAreNot) {
  const auto half = duration_message<Duration>(-500ms);
  EXPECT_EQ(half.sec, -1);
  EXPECT_EQ(half.nanosec, 500'000'000U);
  EXPECT_EQ(to_duration(half), -500ms);
  EXPECT_EQ(to_duration(duration_message<Duration>(-2s)), -2s);
}

TEST(TimeTest, WhatSecondsCannotHoldIsTheNearestThatTheyCan) {
  EXPECT_EQ(to_duration(duration_message<Duration>(std::chrono::nanoseconds::max())),
            2'147'483'647s + 999'999'999ns);
  EXPECT_EQ(to_duration(duration_message<Duration>(std::chrono::nanoseconds::min())), -2'147'483'648s);
}

TEST(TimeTest, NoValueOfAMessageIsOutOfRange) {
  Duration longest;
  longest.sec = INT32_MAX;
  longest.nanosec = UINT32_MAX;
  EXPECT_EQ(to_duration(longest), 2'147'483'647s + 4'294'967'295ns);
}

TEST(TimeTest, StampsOfSamplesAreReadInPlace) {
  Header header;
  header.stamp.sec = 7;
  header.stamp.nanosec = 8;
  const test::Encoded sample(header);
  EXPECT_EQ(to_time(view_of<Header, all<Header>>(sample.state()).stamp()), Point(7s + 8ns));
  const std::optional<Point> recorded_stamp = to_time(view_of<Header, recorded>(sample.state()).stamp());
  EXPECT_EQ(recorded_stamp, Point(7s + 8ns));
  const test::Encoded without(header, Mask<Header>(Header::Field::frame_id | Header::Field::stamp.sec));
  EXPECT_EQ(to_duration(view_of<Header, recorded>(without.state()).stamp()), std::nullopt);
}

static_assert(to_duration(duration_message<Duration>(1500ms)) == 1500ms);

}  // namespace
}  // namespace sft
