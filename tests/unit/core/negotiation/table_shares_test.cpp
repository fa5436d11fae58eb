#include "core/negotiation/table_shares.h"

#include <gtest/gtest.h>

#include "core/negotiation/early_requests.h"

namespace sft::core {
namespace {

class TableSharesTest : public ::testing::Test {
 protected:
  /// Enters what may enter, and takes out what has to leave for it. Returns how many came in.
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

TEST_F(TableSharesTest, ACrowdedTopicHasAShareForEachAnnouncer) {
  EXPECT_EQ(announce(1, 60, "points"), 40);
  EXPECT_EQ(announce(2, 60, "points"), 10);
  EXPECT_EQ(announce(3, 60, "points"), 10);
  EXPECT_EQ(announce(1, 60, "other"), 40) << "each topic for itself";
}

TEST_F(TableSharesTest, WhatLeavesMakesRoom) {
  announce(1, 400);
  for (EndpointId id = 1; id <= 400; ++id) shares.remove(id);
  shares.remove(400);
  EXPECT_EQ(shares.size(), 0U);
  EXPECT_EQ(announce(1, 60, "points"), 40);
}

Request request(EndpointId reader, std::uint64_t sequence, AnnouncerId announcer) {
  Request r;
  r.reader = reader;
  r.sequence = sequence;
  r.announcer = announcer;
  return r;
}

TEST(EarlyRequestsTest, OfOneReaderTheNewestOfItsOwnAnnouncerCounts) {
  EarlyRequests early(10);
  for (const std::uint64_t sequence : {2U, 4U, 3U}) early.keep(request(7, sequence, 1));
  early.keep(request(7, 9, 2));
  const auto taken = early.take(7, 1);
  ASSERT_EQ(taken.size(), 1U);
  EXPECT_EQ(taken[0].sequence, 4U);
  EXPECT_TRUE(early.take(7, 1).empty());
}

TEST(EarlyRequestsTest, WhatOthersSaidCountsWhereItsOwnAnnouncerSaidNothing) {
  EarlyRequests early(10);
  early.keep(request(7, 9, 2));
  EXPECT_EQ(early.take(7, 1).size(), 1U);
}

TEST(EarlyRequestsTest, WhoMakesUpReadersWithoutEndPushesOutItsOwn) {
  EarlyRequests early(100);
  EXPECT_FALSE(early.keep(request(7, 2, 1)));
  for (EndpointId made_up = 1000; made_up < 11'000; ++made_up) early.keep(request(made_up, 1, 2));
  EXPECT_TRUE(early.keep(request(8, 2, 1)));
  EXPECT_EQ(early.take(7, 1).size(), 1U);
  EXPECT_EQ(early.take(8, 1).size(), 1U);
  EXPECT_EQ(early.take(10'999, 2).size(), 1U) << "the newest one is kept";
  EXPECT_EQ(early.take(1000, 2).size(), 0U);
}

}  // namespace
}  // namespace sft::core
