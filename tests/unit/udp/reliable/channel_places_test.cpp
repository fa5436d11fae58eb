#include "udp_transport/reliable/channel_places.h"

#include <gtest/gtest.h>

#include "udp_transport/reliable/reported_end.h"

namespace sft::udp {
namespace {

using namespace std::chrono_literals;

TEST(ChannelPlacesTest, CountOnWhereTheChannelBeforeEnded) {
  ChannelPlaces places;
  EXPECT_EQ(places.place_of(7), 7U);
  places.begin(1, 100);
  EXPECT_EQ(places.place_of(1), 100U);
  EXPECT_EQ(places.ordinal_of(102), 3U);
}

TEST(ChannelPlacesTest, TakeOrdinalsThatAreNotFollowedForTheFirstOne) {
  ChannelPlaces places;
  places.begin(50, 10);
  EXPECT_FALSE(places.follows(49));
  EXPECT_EQ(places.place_of(49), 10U);
  EXPECT_EQ(places.first(), 10U);
}

TEST(ReportedEndTest, IsBelievedOnceTheWriterInsistsOnIt) {
  ReportedEnd end;
  const ReportedEnd::Time now{1h};
  EXPECT_FALSE(end.insists_on(5, now));
  EXPECT_FALSE(end.insists_on(5, now + 249ms));
  EXPECT_TRUE(end.insists_on(5, now + 250ms));
  EXPECT_FALSE(end.insists_on(6, now + 300ms)) << "the writer says something else";
  end.agrees();
  EXPECT_FALSE(end.insists_on(6, now + 1s)) << "something new came in between";
}

TEST(ReportedEndTest, TellsNothingNewOfSamplesThatAreNotFollowed) {
  ReportedEnd end;
  end.begin(10);
  EXPECT_FALSE(end.is_news({.first = 5, .end = 10}));
  EXPECT_FALSE(end.is_news({.first = 11, .end = 11})) << "the writer keeps nothing";
  EXPECT_TRUE(end.is_news({.first = 5, .end = 11}));
  end.go_back_to(7);
  EXPECT_TRUE(end.is_news({.first = 5, .end = 8}));
}

}  // namespace
}  // namespace sft::udp
