// Samples that have been passed over too often, because those of other writers have older stamps.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "tests/unit/core/subscribe/intake_fixture.h"

namespace sft::core {
namespace {

using ::testing::ElementsAre;

TEST_F(IntakeTest, AWriterWhoseClockIsAheadIsHeardBesideOneThatAlwaysHasANextSample) {
  constexpr EndpointId ahead = 8;
  for (std::uint64_t i = 1; i <= 200; ++i) in_memory({.sequence = i});
  for (std::uint64_t i = 1; i <= 3; ++i)
    over_network({.sequence = i, .writer = ahead, .stamp_ns = 1'000'000});
  std::vector<std::uint64_t> places;  // of the samples of that writer among all
  for (std::uint64_t place = 1; place <= 100; ++place) {
    if (take().info.writer == ahead) places.push_back(place);
  }
  EXPECT_THAT(places, ElementsAre(17, 34, 51));
}

TEST_F(IntakeTest, APathThatWasPassedOverChangesNoOrderOfTheSamplesOfOneWriter) {
  over_network({.sequence = 100});
  for (std::uint64_t i = 1; i <= 40; ++i) in_memory({.sequence = i});
  for (std::uint64_t i = 1; i <= 40; ++i) EXPECT_EQ(take().info.sequence, i);
  EXPECT_EQ(take().info.sequence, 100U);
}

TEST_F(IntakeTest, APathThatWasPassedOverHidesNoOtherOneWithSamplesOfAnotherWriter) {
  constexpr EndpointId ahead = 8;
  over_network({.sequence = 100});
  for (std::uint64_t i = 1; i <= 40; ++i) in_memory({.sequence = i});
  take();
  intake->put(Inlet::vanilla, sample({.sequence = 1, .writer = ahead, .stamp_ns = 1'000'000}));
  for (std::uint64_t i = 1; i <= passed_over_max; ++i) EXPECT_NE(take().info.writer, ahead) << i;
  EXPECT_EQ(take().info.writer, ahead);
}

TEST_F(IntakeTest, APathThatWasPassedOverLetsEarlierSamplesOfItsWriterGoFirst) {
  over_network({.sequence = 3, .stamp_ns = 1'000'000});
  for (std::uint64_t i = 1; i <= passed_over_max; ++i) in_memory({.sequence = i, .writer = 8});
  for (std::uint64_t i = 1; i <= 2; ++i) in_memory({.sequence = i, .stamp_ns = 900'000});
  for (std::uint64_t i = 1; i <= passed_over_max; ++i) EXPECT_EQ(take().info.writer, 8U) << i;
  intake->put(Inlet::vanilla, sample({.sequence = 17, .writer = 7}));
  EXPECT_THAT(taken(), ElementsAre(17, 1, 2, 3));
}

TEST_F(IntakeTest, ASampleThatWaitsHoldsUpNoOtherWriterHoweverOftenItWasPassedOver) {
  in_memory({1});
  EXPECT_THAT(taken(), ElementsAre(1));
  now_ns = 10;
  in_memory({.sequence = 3, .stamp_ns = 1'000'000, .diverted = 2, .diverted_ns = 5});
  for (std::uint64_t i = 1; i <= 2 * passed_over_max; ++i) {
    intake->put(Inlet::vanilla, sample({.sequence = i, .writer = 8}));
    EXPECT_EQ(take().info.writer, 8U) << i;
  }
  over_network({2});
  EXPECT_THAT(taken(), ElementsAre(2, 3));
}

}  // namespace
}  // namespace sft::core
