// Estimates of the bytes that selections would have sent.
#include "tools/recording/estimate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <numeric>

#include "sft/json.h"
#include "sft/msg_text.h"
#include "tools/recording/sample_type.h"

namespace sft::recording {
namespace {

class EstimateTest : public ::testing::Test {
 protected:
  TopicEstimate estimate(std::string_view selection) const {
    const Selection parsed = selection_of(type, selection).value();
    return TopicEstimate(type, selection.empty() ? nullptr : &parsed);
  }
  std::vector<std::byte> battery(double voltage) const {
    return cdr_from_json(type.type(), "{\"header\": {\"frame_id\": \"abc\"}, \"voltage\": " +
                                          std::to_string(voltage) + ", \"cell_voltage\": [1, 2, 3]}")
        .value();
  }

  DynamicType type =
      find_msg("sensor_msgs/BatteryState", std::array<std::filesystem::path, 1>{SFT_TEST_INTERFACES}).value();
};

TEST_F(EstimateTest, TheBytesOfAllFieldsAreThoseOfTheBody) {
  TopicEstimate all = estimate("");
  const std::vector<std::byte> cdr = battery(12);
  ASSERT_TRUE(all.add(cdr, 1));
  const auto fields = all.fields();
  const std::uint64_t sum = std::accumulate(fields.begin(), fields.end(), std::uint64_t{0},
                                            [](auto s, const auto& f) { return s + f.bytes; });
  EXPECT_EQ(sum, all.bytes());
  EXPECT_LE(cdr.size() - 4 - all.bytes(), 3U);
  EXPECT_EQ(fields.front().path, "cell_voltage");
  EXPECT_EQ(fields.front().bytes, 16U);
  EXPECT_EQ(all.selected_bytes(), all.bytes());
  EXPECT_EQ(all.samples(), 1U);
  EXPECT_EQ(all.selected_samples(), 1U);
}

TEST_F(EstimateTest, ASelectionCountsWhatAPublisherWouldSend) {
  TopicEstimate some = estimate("header.stamp, voltage @ changed 10%");
  for (const double voltage : {12.0, 12.1, 14.0, 14.0}) ASSERT_TRUE(some.add(battery(voltage), 1));
  EXPECT_EQ(some.samples(), 4U);
  EXPECT_EQ(some.selected_samples(), 2U);
  EXPECT_EQ(some.selected_bytes(), 2U * 12);
}

TEST_F(EstimateTest, ARateCountsOneSampleAPeriod) {
  TopicEstimate some = estimate("voltage @ at most 1 Hz");
  for (std::uint64_t i = 0; i < 30; ++i) ASSERT_TRUE(some.add(battery(12), i * 100'000'000));
  EXPECT_EQ(some.selected_samples(), 3U);
  EXPECT_EQ(some.samples(), 30U);
  EXPECT_GT(some.bytes(), 10 * some.selected_bytes());
}

TEST_F(EstimateTest, WhatTheRateWithholdsIsNoSampleWithWhichTheNextOneIsCompared) {
  TopicEstimate some = estimate("voltage @ changed 10% at most 1 Hz");
  ASSERT_TRUE(some.add(battery(12), 0));
  ASSERT_TRUE(some.add(battery(14), 500'000'000));
  ASSERT_TRUE(some.add(battery(14), 1'000'000'000)) << "it differs from the first one";
  EXPECT_EQ(some.selected_samples(), 2U);
}

TEST_F(EstimateTest, BytesThatDoNotFitAreRefused) {
  TopicEstimate all = estimate("");
  std::vector<std::byte> cdr = battery(12);
  cdr.resize(20);
  EXPECT_FALSE(all.add(cdr, 1));
  EXPECT_FALSE(all.add({}, 1));
  EXPECT_EQ(all.samples(), 0U);
  EXPECT_EQ(all.bytes(), 0U);
  EXPECT_EQ(all.selected_samples(), 0U);
  EXPECT_EQ(all.selected_bytes(), 0U);
  EXPECT_TRUE(all.fields().empty());
}

}  // namespace
}  // namespace sft::recording
