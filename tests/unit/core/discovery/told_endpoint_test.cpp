// The listener is told of one endpoint, claim by claim.
#include "core/discovery/told_endpoint.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sft::core {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

class ToldEndpointTest : public ::testing::Test {
 protected:
  static Claim claim(std::uint64_t revision, AnnouncerId by = 11) {
    Endpoint e;
    e.id = 5;
    e.node_id = 77;
    e.revision = revision;
    e.announcer = by;
    e.life_lease = 1000ms;
    e.request.sequence = 1;
    Claim made;
    made.speaker = {1, by};
    made.endpoint = std::make_shared<const Endpoint>(e);
    return made;
  }
  static Request request(std::uint64_t sequence) {
    Request made;
    made.reader = 5;
    made.sequence = sequence;
    return made;
  }
  static Claim with_request(Claim asking, std::uint64_t sequence) {
    asking.request = request(sequence);
    return asking;
  }
  std::vector<std::string> news() {
    std::vector<std::string> all;
    for (const News& one : std::exchange(told_news, {})) {
      if (const auto* seen = std::get_if<EndpointSeen>(&one))
        all.push_back("seen " + std::to_string(seen->endpoint->revision));
      if (const auto* asked = std::get_if<Request>(&one))
        all.push_back("request " + std::to_string(asked->sequence));
      if (std::holds_alternative<EndpointDeparted>(one)) all.emplace_back("departed");
      if (std::holds_alternative<EndpointLost>(one)) all.emplace_back("lost");
    }
    return all;
  }

  std::vector<News> told_news;
  ToldEndpoint told{told_news};
  Time now{1h};
};

TEST_F(ToldEndpointTest, AnEndpointThatSeemsToHaveAnotherTopicHasDepartedFromTheFormerOne) {
  told.believe(claim(1), {}, now);
  Claim forged = claim(2);
  Endpoint elsewhere = *forged.endpoint;
  elsewhere.topic = "another";
  forged.endpoint = std::make_shared<const Endpoint>(elsewhere);
  told.believe(forged, {}, now);
  told.believe(claim(3), {}, now);
  EXPECT_THAT(news(), ElementsAre("seen 1", "departed", "seen 2", "departed", "seen 3"));
}

TEST_F(ToldEndpointTest, WhatWasToldAndHoldsCanBeRepeated) {
  std::vector<News> none;
  told.repeat(none);
  EXPECT_TRUE(none.empty());
  told.believe(with_request(claim(1), 7), {}, now);
  (void)news();
  told.repeat(told_news);
  EXPECT_THAT(news(), ElementsAre("seen 1", "request 7"));
  told.lose(now - 1h, now);
  (void)news();
  told.repeat(told_news);
  EXPECT_THAT(news(), IsEmpty()) << "it is lost";
}

TEST_F(ToldEndpointTest, TheSameAnnouncementIsToldOnce) {
  told.believe(claim(1), {}, now);
  told.believe(claim(1), {}, now);
  EXPECT_THAT(news(), ElementsAre("seen 1"));
  told.believe(claim(2), {}, now);
  EXPECT_THAT(news(), ElementsAre("seen 2"));
}

TEST_F(ToldEndpointTest, ALinkThatFallsSilentIsNews) {
  told.believe(claim(1), {}, now);
  told.believe(claim(1), {2}, now);
  told.believe(claim(1), {2}, now);
  EXPECT_THAT(news(), ElementsAre("seen 1", "seen 1"));
}

TEST_F(ToldEndpointTest, ARequestIsToldOnceAndOnlyIfItIsNewer) {
  told.believe(with_request(claim(1), 3), {}, now);
  EXPECT_THAT(news(), ElementsAre("seen 1", "request 3"));
  told.request(request(3));
  told.request(request(2));
  EXPECT_THAT(news(), IsEmpty());
  told.forget_request();
  told.request(request(2));
  EXPECT_THAT(news(), ElementsAre("request 2"));
}

TEST_F(ToldEndpointTest, AnEndpointIsLostAtOnceIfItsNodeWasSilentBefore) {
  told.believe(claim(1), {}, now);
  news();
  told.lose(now - 10s, now);
  told.lose(now - 10s, now);
  EXPECT_THAT(news(), ElementsAre("lost"));
  EXPECT_TRUE(told.is_lost_before(now));
}

TEST_F(ToldEndpointTest, AnEndpointThatWasHeardAMomentAgoHasItsLeaseToReturn) {
  told.believe(claim(1), {}, now);
  news();
  told.lose(now, now);
  told.lose(now, now + 999ms);
  EXPECT_THAT(news(), IsEmpty());
  told.lose(now, now + 1000ms);
  EXPECT_THAT(news(), ElementsAre("lost"));
  told.believe(claim(1), {}, now + 2s);
  EXPECT_THAT(news(), ElementsAre("seen 1")) << "it has returned";
}

TEST_F(ToldEndpointTest, WhatIsInDoubtIsTakenBackIfAnotherClaimSaysOtherwise) {
  told.believe(claim(9), {}, now);
  told.doubt();
  news();
  told.believe(claim(2, 12), {}, now);
  EXPECT_THAT(news(), ElementsAre("departed", "seen 2"));
  EXPECT_FALSE(told.is_in_doubt());
}

TEST_F(ToldEndpointTest, ALinkThatIsMadeAnewHasTimeToTellTheRequestAfterTheEndpoint) {
  told.believe(with_request(claim(1), 7), {}, now);
  told.doubt();
  news();
  told.believe(claim(1, 12), {}, now);
  EXPECT_THAT(news(), IsEmpty());
  told.believe(with_request(claim(1, 12), 7), {}, now + 100ms);
  EXPECT_THAT(news(), ElementsAre("seen 1", "request 7"));
}

TEST_F(ToldEndpointTest, OlderAnnouncementsOfTheSameNodeByOthersAreBehind) {
  told.believe(claim(2), {}, now);
  EXPECT_TRUE(told.is_ahead_of(claim(1, 12)));
  EXPECT_FALSE(told.is_ahead_of(claim(1))) << "it is the same participant";
  EXPECT_FALSE(told.is_ahead_of(claim(2, 12)));
}

}  // namespace
}  // namespace sft::core
