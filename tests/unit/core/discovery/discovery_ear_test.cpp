// The ear compares what others say of themselves with what it knows, as far as it listens to them.
#include "core/discovery/discovery_ear.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/discovery/own_announcements.h"

namespace sft::core {
namespace {

using ::testing::Contains;
using ::testing::IsSupersetOf;
using ::testing::Not;

constexpr Speaker peer{1, 11};
constexpr NodeId its_node = 77;

class DiscoveryEarTest : public ::testing::Test {
 protected:
  DiscoveryEarTest() {
    ear.link_expected(peer.link, true);
    ear.participant_speaks(peer);
    for (const auto& [role, id] : {std::pair(Role::writer, 5), std::pair(Role::reader, 6)}) {
      Endpoint endpoint;
      endpoint.id = static_cast<EndpointId>(id);
      endpoint.role = role;
      endpoint.node_id = its_node;
      (void)own.announce(endpoint);
    }
  }

  void hears(Role role) { ear.hears(role, now()); }
  void announcement_comes(Role role) {
    Endpoint endpoint;
    endpoint.id = role == Role::writer ? 5 : 6;
    endpoint.role = role;
    endpoint.node_id = its_node;
    endpoint.revision = 1;
    ear.endpoint_came(peer, endpoint);
  }
  /// True if something that the peer has announced seems to be missing: its next sign tells of that.
  bool doubts() {
    at += 2 * SignPace().repeated_for();  // an earlier doubt does not last so long
    Assertion sign{.node = its_node, .writers = {}};
    sign.digest_of_writers = own.digest(Role::writer);
    sign.digest_of_readers = own.digest(Role::reader);
    ear.assertion_came(peer, sign, lease_default);
    at += std::chrono::milliseconds(500);  // it does not look more often
    (void)ear.look_for_deafness(std::chrono::seconds(20), now());
    const SignPace& signs = ear.tick(now()).signs;
    EXPECT_NE(signs.wants(now()), signs.is_calm(now())) << "there is no other reason";
    return signs.wants(now());
  }

  void sign_comes(bool wants_signs = false) {
    Assertion sign{.node = its_node, .writers = {}};
    sign.wants_signs = wants_signs;
    ear.assertion_came(peer, sign, lease_default);
  }
  bool is_calm_after(Time::duration pause) {
    at += pause;
    return ear.tick(now()).signs.is_calm(now());
  }
  static Time now() { return at; }
  static inline Time at{std::chrono::seconds(1000)};

  DiscoveryEar ear{life_signs_to_all, &DiscoveryEarTest::now};

 private:
  OwnAnnouncements own;  ///< of the peer
};

TEST_F(DiscoveryEarTest, MissesNothingOfARoleThatItDoesNotListenTo) {
  EXPECT_FALSE(doubts()) << "it listens to nobody";
  hears(Role::writer);
  EXPECT_TRUE(doubts());
  announcement_comes(Role::writer);
  EXPECT_FALSE(doubts());
  hears(Role::reader);
  EXPECT_TRUE(doubts());
  announcement_comes(Role::reader);
  EXPECT_FALSE(doubts());
}

TEST_F(DiscoveryEarTest, RemembersALateSignForHalfAMinute) {
  sign_comes();
  EXPECT_TRUE(is_calm_after(std::chrono::seconds(1)));
  EXPECT_FALSE(is_calm_after(std::chrono::seconds(1))) << "the next one is late";
  sign_comes();
  EXPECT_FALSE(is_calm_after(std::chrono::seconds(1)));
  for (int second = 2; second < 30; ++second) {
    sign_comes();
    EXPECT_FALSE(is_calm_after(std::chrono::seconds(1)));
  }
  sign_comes();
  EXPECT_TRUE(is_calm_after(std::chrono::seconds(1)));
}

TEST_F(DiscoveryEarTest, FollowsTheWishOfAnotherProcess) {
  sign_comes();
  EXPECT_TRUE(is_calm_after(std::chrono::seconds(1)));
  sign_comes(true);
  EXPECT_FALSE(is_calm_after(std::chrono::seconds(1)));
  EXPECT_FALSE(ear.tick(now()).signs.wants(now())) << "it does not repeat the wish";
  sign_comes();
  EXPECT_FALSE(is_calm_after(std::chrono::seconds(1)));
  sign_comes();
  EXPECT_TRUE(is_calm_after(std::chrono::seconds(1)));
}

struct Log final : DiscoveryListener {
  void endpoint_seen(Endpoint endpoint) override { told.push_back("seen " + std::to_string(endpoint.id)); }
  void endpoint_departed(EndpointId id) override { told.push_back("departed " + std::to_string(id)); }
  void endpoint_lost(EndpointId id) override { told.push_back("lost " + std::to_string(id)); }
  void request_received(Request) override {}
  void liveliness_asserted(Assertion sign) override { told.push_back("lives " + std::to_string(sign.node)); }
  void node_lost(NodeId id) override { told.push_back("node lost " + std::to_string(id)); }
  void control_malformed(std::string) override {}

  std::vector<std::string> told;
};

/// The first node has the writer 10, and the second one the reader 20.
class NodesOfOneProcess : public DiscoveryEarTest {
 protected:
  NodesOfOneProcess() {
    ear.with_nodes([&](ProcessNodes& nodes, const LinkMerge&) {
      nodes.join(first);
      nodes.join(second);
    });
    announces(first, endpoint(Role::writer, 10, 1));
    announces(second, endpoint(Role::reader, 20, 2));
  }

  static Endpoint endpoint(Role role, EndpointId id, NodeId node) {
    Endpoint endpoint;
    endpoint.id = id;
    endpoint.role = role;
    endpoint.node_id = node;
    endpoint.revision = 1;
    return endpoint;
  }
  void announces(const std::shared_ptr<NodeListener>& member, const Endpoint& endpoint) {
    ear.with_nodes([&](ProcessNodes& nodes, LinkMerge& merge) {
      merge.owns(endpoint.id);
      nodes.announced(member, endpoint, merge.endpoints());
    });
    ear.pass_on();
  }

  Log first_log, second_log;
  const std::shared_ptr<NodeListener> first = std::make_shared<NodeListener>(first_log),
                                      second = std::make_shared<NodeListener>(second_log);
};

TEST_F(NodesOfOneProcess, BelieveNobodyElseAboutEachOther) {
  EXPECT_EQ(first_log.told, std::vector<std::string>{"seen 20"});
  first_log.told.clear();
  second_log.told.clear();

  ear.assertion_came(peer, {.node = 1, .writers = {10}}, std::chrono::seconds(1));
  ear.participant_departed(peer);
  (void)ear.tick(std::chrono::steady_clock::now() + std::chrono::hours(1));
  ear.endpoint_came(peer, endpoint(Role::writer, 10, 1));
  ear.endpoint_withdrawn(peer, 10);
  ear.pass_on();
  EXPECT_EQ(second_log.told, std::vector<std::string>{});
  EXPECT_EQ(first_log.told, (std::vector<std::string>{"seen 10", "departed 10"})) << "it answers for itself";
}

TEST_F(NodesOfOneProcess, DoNotTakeBackWhatOneOfThemHasWithdrawn) {
  ear.with_nodes([&](ProcessNodes& nodes, LinkMerge& merge) {
    merge.disowns(10, 1, std::chrono::steady_clock::now());
    nodes.withdrawn(10, merge.endpoints());
  });
  ear.pass_on();
  second_log.told.clear();
  ear.endpoint_came(peer, endpoint(Role::writer, 10, 1));
  EXPECT_EQ(second_log.told, std::vector<std::string>{}) << "somebody repeats it";
}

TEST_F(NodesOfOneProcess, AreToldThatALostEndpointHasDepartedOnceItsNodeSpeaksOfNoneByAnotherParticipant) {
  constexpr Speaker its_next{peer.link, 12};
  ear.participant_speaks(its_next);
  const auto a_second_passes = [&] {
    at += std::chrono::seconds(1);
    ear.assertion_came(its_next, {.node = its_node, .writers = {}}, lease_default);
    (void)ear.tick(now());
    (void)ear.look_for_deafness(std::chrono::seconds(20), now());
    ear.pass_on();
  };
  hears(Role::writer);
  ear.endpoint_came(peer, endpoint(Role::writer, 30, its_node));
  ear.participant_departed(peer);
  second_log.told.clear();
  for (int seconds = 0; seconds < 4; ++seconds) a_second_passes();
  EXPECT_THAT(second_log.told, Not(Contains("departed 30"))) << "it may return";
  for (int seconds = 4; seconds < 6; ++seconds) a_second_passes();
  EXPECT_THAT(second_log.told, IsSupersetOf({"lost 30", "departed 30"}));
}

}  // namespace
}  // namespace sft::core
