// A participant that announces without end takes no room from others.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/unit/core/discovery/link_merge_fixture.h"

namespace sft::core {
namespace {

using namespace std::chrono_literals;

TEST_F(LinkMergeTest, GivesEveryParticipantAShareWhateverOneOfThemAnnounces) {
  LinkMerge small({.share = 4, .crowded = 10, .endpoints = 40});
  for (EndpointId id = 1; id <= 100; ++id) small.endpoint_came(stranger, endpoint(1, "flood", id), now);
  small.take_news();
  for (EndpointId id = 1001; id <= 1004; ++id) small.endpoint_came(by_lan, endpoint(1, "honest", id), now);
  for (const News& news : small.take_news()) EXPECT_TRUE(std::holds_alternative<EndpointSeen>(news));
}

TEST_F(LinkMergeTest, TakesNoMoreThanThereIsRoomFor) {
  LinkMerge small({.share = 4, .crowded = 10, .endpoints = 12});
  const auto taken = [&](const Speaker& speaker, EndpointId first) {
    for (EndpointId id = first; id < first + 100; ++id)
      small.endpoint_came(speaker, endpoint(1, "many", id), now);
    const std::vector<News> news = small.take_news();
    return std::ranges::count_if(news, [](const News& n) { return std::holds_alternative<EndpointSeen>(n); });
  };
  EXPECT_EQ(taken(stranger, 1), 10);
  EXPECT_EQ(taken(by_lan, 1001), 2) << "less than its share";
}

TEST_F(LinkMergeTest, KeepsAsManyBytesOfLargeDescriptionsAsOfUsualOnes) {
  LinkMerge small({.share = 4, .crowded = 10, .endpoints = 40});
  const auto taken = [&](EndpointId id, std::uint64_t revision, std::size_t description_bytes) {
    Endpoint described = endpoint(revision, "many", id);
    described.type_description.resize(description_bytes);
    small.endpoint_came(stranger, described, now);
    const std::vector<News> news = small.take_news();
    return std::ranges::any_of(news, [](const News& n) { return std::holds_alternative<EndpointSeen>(n); });
  };
  EXPECT_TRUE(taken(1, 1, 65'536)) << "counts as eight";
  EXPECT_FALSE(taken(2, 1, 65'536));
  EXPECT_TRUE(taken(3, 1, 8192));
  EXPECT_FALSE(taken(3, 2, 65'536)) << "nor is it taken where it was small before";
  EXPECT_TRUE(taken(1, 2, 100)) << "it has become small";
  EXPECT_TRUE(taken(3, 3, 65'536));
  small.endpoint_withdrawn(stranger, 3, now);
  EXPECT_TRUE(taken(4, 1, 65'536)) << "there is as much room as before";
}

TEST_F(LinkMergeTest, HasRoomAgainWhereAnnouncementsGo) {
  LinkMerge small({.share = 2, .crowded = 0, .endpoints = 3});
  const auto comes = [&](const Speaker& speaker, EndpointId id) {
    small.endpoint_came(speaker, endpoint(1, "honest", id), now);
  };
  const auto is_refused = [&] {
    const std::vector<News> news = small.take_news();
    return std::ranges::any_of(news, [](const News& n) { return std::holds_alternative<Refused>(n); });
  };
  comes(by_lan, 5);
  for (EndpointId id = 10; id < 15; ++id) {
    comes(by_lan, id);
    small.endpoint_withdrawn(by_lan, id, now);
    EXPECT_FALSE(is_refused()) << "of that one alone";
  }
  for (int i = 0; i < 5; ++i) {
    comes(stranger, 5);
    small.endpoint_withdrawn(stranger, 5, now);
    EXPECT_FALSE(is_refused()) << "of what another one announces, too";
  }
  for (int i = 0; i < 5; ++i) {
    comes(by_radio, 5);
    small.link_dropped(radio, now);
    EXPECT_FALSE(is_refused()) << "with a link";
  }
  for (int i = 0; i < 5; ++i) {
    comes(by_radio, 5);
    small.participant_departed(by_radio, now);
    now += 61s;
    small.tick(now);
    EXPECT_FALSE(is_refused()) << "long ago";
  }
}

TEST_F(LinkMergeTest, ForgetsWhoIsLostForLong) {
  LinkMerge small({.share = 1, .crowded = 1, .endpoints = 1});
  small.endpoint_came(by_lan, endpoint(1), now);
  now += 2s;
  small.participant_departed(by_lan, now);
  now += 31s;
  small.endpoint_unheard(lan, 5, now);  // it is not, any more
  now += 30s;
  small.tick(now);
  small.take_news();
  small.endpoint_came(by_radio, endpoint(1, "other", 6), now);
  EXPECT_TRUE(std::holds_alternative<EndpointSeen>(small.take_news().at(0))) << "there is room again";
}

}  // namespace
}  // namespace sft::core
