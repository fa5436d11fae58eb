// The results of a run. Figures that cannot be known are left out.
#include "tools/perf/result.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace sft::perf {
namespace {

using ::testing::HasSubstr;

Outcome run_of(std::uint64_t sent, std::uint64_t arrived, std::uint64_t returned) {
  Outcome run{.clocks = "one clock, of one host", .clocks_within_s = 0};
  Lane lane{
      .name = "sft", .fields = "*", .path = "udp", .sent = sent, .arrived = arrived, .returned = returned};
  lane.seconds = 1;
  for (std::uint64_t i = 0; i < returned; ++i) {
    lane.latency.add(50'000);
    lane.there.add(40'000);
    lane.back.add(60'000);
  }
  run.lanes.push_back(lane);
  return run;
}

TEST(ResultTest, LossesAreToldByDirection) {
  const auto lane = json_of(run_of(100, 97, 92), {})["lanes"][0];
  EXPECT_EQ(lane["lost_there"], 3);
  EXPECT_EQ(lane["lost_back"], 5);
}

TEST(ResultTest, WhatDidNotComeIsNullAndNotANumber) {
  const std::string json = json_of(run_of(100, 0, 0), {}).dump();
  EXPECT_THAT(json, HasSubstr(R"("p50":null)"));
  EXPECT_THAT(json, HasSubstr(R"("jitter_s":null)"));
  EXPECT_EQ(json.find("nan"), json.npos);
}

TEST(ResultTest, WhatWasNeverSentHasNoRate) {
  Outcome run = run_of(0, 0, 0);
  run.answers = false;
  run.lanes[0].seconds = 0;
  EXPECT_THAT(text_of(run), HasSubstr("arrived: 0 samples, 0 B a second"));
  EXPECT_EQ(text_of(run).find("nan"), std::string::npos) << text_of(run);
}

TEST(ResultTest, OneWayTimesAreToldOnlyIfTheClocksAreKnownToAgree) {
  Outcome run = run_of(10, 10, 10);
  EXPECT_FALSE(json_of(run, {})["lanes"][0]["there_s"].is_null());
  run.clocks_within_s.reset();
  EXPECT_TRUE(json_of(run, {})["lanes"][0]["there_s"].is_null());
}

TEST(ResultTest, ClocksThatDisagreeAreToldByHowMuch) {
  Outcome run = run_of(10, 10, 10);
  run.offset_s = -0.2;
  run.offset_error_s = 0.0001;
  EXPECT_EQ(why_no_one_way(run), "clocks disagree by -200.00 ms");
  EXPECT_THAT(text_of(run), HasSubstr("no one-way times: clocks disagree by -200.00 ms"));
  EXPECT_TRUE(json_of(run, {})["lanes"][0]["back_s"].is_null());
}

TEST(ResultTest, ThePictureHasACurveForEachLane) {
  Outcome run = run_of(10, 10, 10);
  run.lanes.push_back(run.lanes[0]);
  const std::string svg = svg_of(run);
  std::size_t curves = 0;
  for (std::size_t at = 0; (at = svg.find("<polyline", at)) != svg.npos; ++at) ++curves;
  EXPECT_EQ(curves, 2U);
  EXPECT_THAT(svg, HasSubstr("</svg>"));
  EXPECT_NE(svg_of(Outcome{}), "") << "without figures there are axes only";
}

TEST(UsageTest, AnInterfaceThatDisappearsCountsAsNothing) {
  const Usage used = Usage{.bytes_in = 5, .bytes_out = 9} - Usage{.bytes_in = 7, .bytes_out = 2};
  EXPECT_EQ(used.bytes_in, 0U);
  EXPECT_EQ(used.bytes_out, 7U);
}

TEST(ClockTest, ProgramsOfOneHostHaveOneClock) {
  const HostClock here{.boot = "a", .is_kept = false};
  EXPECT_EQ(agreement(here, here).within_s, 0);
}

TEST(ClockTest, HostsAgreeAsWellAsBothAreKept) {
  const HostClock here{.boot = "a", .is_kept = true, .error_s = 0.001};
  const HostClock there{.boot = "b", .is_kept = true, .error_s = 0.002};
  EXPECT_DOUBLE_EQ(agreement(here, there).within_s.value(), 0.003);
  const HostClock free{.boot = "c"};
  EXPECT_FALSE(agreement(here, free).within_s);
  EXPECT_THAT(agreement(here, free).words, HasSubstr("the clock of the other host is not kept"));
}

}  // namespace
}  // namespace sft::perf
