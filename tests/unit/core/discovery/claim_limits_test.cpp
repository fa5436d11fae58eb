// A node keeps only so much of what participants say.
#include <gtest/gtest.h>

#include <utility>

#include "core/discovery/claim_counts.h"
#include "core/discovery/requests_in_advance.h"

namespace sft::core {
namespace {

using namespace std::chrono_literals;

TEST(ClaimCounts, AParticipantHasMoreThanItsShareWhileThereIsRoomForEverybody) {
  ClaimCounts counts({.share = 2, .crowded = 4, .all = 6});
  for (int i = 0; i < 4; ++i) {
    EXPECT_TRUE(counts.has_room_for(1, 1));
    counts.add(1, 1);
  }
  EXPECT_FALSE(counts.has_room_for(1, 1));
  EXPECT_TRUE(counts.has_room_for(2, 1)) << "its share is its own";
  counts.add(2, 1);
  counts.add(2, 1);
  EXPECT_FALSE(counts.has_room_for(3, 1)) << "there is room for no more";
  counts.remove(1, 1);
  EXPECT_TRUE(counts.has_room_for(3, 1));
  EXPECT_FALSE(counts.has_room_for(1, 1));
}

TEST(ClaimCounts, AnAnnouncementOfMoreWeightNeedsMoreRoom) {
  ClaimCounts counts({.share = 4, .crowded = 4, .all = 8});
  EXPECT_TRUE(counts.has_room_for(1, 4));
  EXPECT_FALSE(counts.has_room_for(1, 5));
  counts.add(1, 3);
  EXPECT_TRUE(counts.has_room_for(1, 1));
  EXPECT_FALSE(counts.has_room_for(1, 2));
  counts.remove(1, 2);
  EXPECT_TRUE(counts.has_room_for(1, 3)) << "what is removed makes room";
}

class RequestsInAdvanceTest : public ::testing::Test {
 protected:
  static constexpr Speaker one{1, 11}, other{2, 12};
  void keep(const Speaker& speaker, std::uint64_t sequence, EndpointId reader = 5) {
    Request request;
    request.reader = reader;
    request.sequence = sequence;
    requests.keep(speaker, std::move(request), now);
  }
  std::uint64_t take(const Speaker& speaker, EndpointId reader = 5) {
    const std::optional<Request> request = requests.take(speaker, reader);
    return request ? request->sequence : 0;
  }

  Time now{1h};
  RequestsInAdvance requests{3};
};

TEST_F(RequestsInAdvanceTest, TheNewestRequestOfASpeakerIsTakenOnce) {
  keep(one, 1);
  keep(one, 2);
  keep(other, 7);
  EXPECT_EQ(take(one), 2U);
  EXPECT_EQ(take(one), 0U);
  EXPECT_EQ(take(other), 7U);
}

TEST_F(RequestsInAdvanceTest, IfThereAreTooManyTheOldestOneGivesWay) {
  for (const EndpointId reader : {5U, 6U, 7U, 8U}) keep(one, reader, reader);
  EXPECT_EQ(take(one, 5), 0U);
  EXPECT_EQ(take(one, 6), 6U);
}

TEST_F(RequestsInAdvanceTest, RequestsByALinkThatIsDroppedAreForgotten) {
  keep(one, 1);
  keep(other, 2);
  requests.forget_link(1);
  EXPECT_EQ(take(one), 0U);
  EXPECT_EQ(take(other), 2U);
}

TEST_F(RequestsInAdvanceTest, RequestsAreForgottenByTheirAge) {
  keep(one, 1);
  now += 2s;
  keep(other, 2);
  requests.forget_if([](EndpointId, Time::duration age) { return age > 1s; }, now);
  EXPECT_EQ(take(one), 0U);
  EXPECT_EQ(take(other), 2U);
}

}  // namespace
}  // namespace sft::core
