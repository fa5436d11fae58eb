#include "core/negotiation/table_shares.h"

#include <gtest/gtest.h>

namespace sft::core {
namespace {

class TableSharesTest : public ::testing::Test {
 protected:
  /// Enters the endpoints that are admitted, and removes the endpoints that they replace. Returns the number
  /// of endpoints that were entered.
  int announce(AnnouncerId announcer, int count, const std::string& topic = "") {
    int entered = 0;
    for (int i = 0; i < count; ++i) {
      const std::string name = topic.empty() ? "topic " + std::to_string(next_) : topic;
      const auto admission = shares.admit(announcer, name);
      if (!admission.granted) continue;
      if (admission.instead_of) shares.remove(*admission.instead_of);
      shares.enter(next_++, announcer, name);
      ++entered;
    }
    return entered;
  }

  TableShares shares{{.entries = 400, .of_announcer = 100, .topic_shares_from = 40, .of_topic = 10}};
  EndpointId next_ = 1;
};

TEST_F(TableSharesTest, OneAnnouncerMayFillTheTableWhileNobodyElseNeedsIt) {
  EXPECT_EQ(announce(1, 500), 400);
  EXPECT_EQ(shares.size(), 400U);
}

TEST_F(TableSharesTest, ANewcomerEntersAFullTableAndWhoHasTheMostLosesItsNewest) {
  announce(1, 500);
  const auto admission = shares.admit(2, "points");
  EXPECT_TRUE(admission.granted);
  EXPECT_EQ(admission.instead_of, EndpointId{400});
  EXPECT_EQ(announce(2, 50), 50);
  EXPECT_EQ(shares.of(1), 350U);
  EXPECT_EQ(shares.size(), 400U);
}

TEST_F(TableSharesTest, InAFullTableNobodyTakesMoreThanItsShareFromOthers) {
  announce(1, 400);
  EXPECT_EQ(announce(2, 300), 100);
  EXPECT_EQ(announce(1, 10), 0);
  EXPECT_EQ(shares.of(1), 300U);
}

TEST_F(TableSharesTest, WhoHasAsManyAsAnybodyTakesNothingFromOthers) {
  for (AnnouncerId announcer = 1; announcer <= 4; ++announcer) announce(announcer, 100);
  for (AnnouncerId announcer = 1; announcer <= 4; ++announcer) EXPECT_EQ(announce(announcer, 1), 0);
  EXPECT_EQ(announce(5, 1), 1);
}

TEST_F(TableSharesTest, EquallyLargeAnnouncersBelowTheirShareDoNotPushEachOtherOut) {
  for (AnnouncerId announcer = 1; announcer <= 5; ++announcer) announce(announcer, 80);
  for (AnnouncerId announcer = 1; announcer <= 5; ++announcer) EXPECT_EQ(announce(announcer, 1), 0);
}

TEST_F(TableSharesTest, ACrowdedTopicHasAShareForEachAnnouncer) {
  EXPECT_EQ(announce(1, 60, "points"), 40);
  EXPECT_EQ(announce(2, 60, "points"), 10);
  EXPECT_EQ(announce(3, 60, "points"), 10);
  EXPECT_EQ(announce(1, 60, "other"), 40) << "each topic for itself";
}

TEST_F(TableSharesTest, WhatLeavesACrowdedTopicMakesRoomThere) {
  for (int round = 0; round < 3; ++round) {
    const EndpointId first = next_;
    EXPECT_EQ(announce(1, 60, "points"), 40);
    for (EndpointId id = first; id < next_; ++id) shares.remove(id);
  }
}

TEST_F(TableSharesTest, WhatLeavesMakesRoom) {
  announce(1, 400);
  for (EndpointId id = 1; id <= 400; ++id) shares.remove(id);
  shares.remove(400);
  EXPECT_EQ(shares.size(), 0U);
  EXPECT_EQ(announce(1, 60, "points"), 40);
}

}  // namespace
}  // namespace sft::core
