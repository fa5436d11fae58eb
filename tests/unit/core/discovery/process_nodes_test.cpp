// These tests check which nodes of a process are told what.
#include "core/discovery/process_nodes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "core/discovery/link_merge.h"

namespace sft::core {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

constexpr Speaker remote{1, 11};
constexpr NodeId remote_node = 77;

struct Deaf final : DiscoveryListener {
  void endpoint_seen(Endpoint) override {}
  void endpoint_departed(EndpointId) override {}
  void endpoint_lost(EndpointId) override {}
  void request_received(Request) override {}
  void liveliness_asserted(Assertion) override {}
  void node_lost(NodeId) override {}
  void control_malformed(std::string) override {}
};

Endpoint endpoint(Role role, EndpointId id, const std::string& topic = "points") {
  Endpoint e;
  e.id = id;
  e.role = role;
  e.node_id = id / 10;
  e.topic = topic;
  e.revision = 1;
  e.request.reader = id;
  return e;
}

Request request(EndpointId reader, std::uint64_t sequence) {
  Request r;
  r.reader = reader;
  r.sequence = sequence;
  return r;
}

std::string text_of(const News& news) {
  if (const auto* seen = std::get_if<EndpointSeen>(&news))
    return (seen->endpoint->life_lease.count() == 0 ? "silent " : "seen ") +
           std::to_string(seen->endpoint->id);
  if (const auto* asked = std::get_if<Request>(&news))
    return "asked by " + std::to_string(asked->reader) + ": " + std::to_string(asked->sequence);
  if (const auto* departed = std::get_if<EndpointDeparted>(&news))
    return "departed " + std::to_string(departed->id);
  if (const auto* lost = std::get_if<EndpointLost>(&news)) return "lost " + std::to_string(lost->id);
  if (const auto* sign = std::get_if<Assertion>(&news)) return "lives " + std::to_string(sign->node);
  if (const auto* lost = std::get_if<NodeLost>(&news)) return "node lost " + std::to_string(lost->id);
  return "refused";
}

class ProcessNodesTest : public ::testing::Test {
 protected:
  std::shared_ptr<NodeListener> joined() {
    auto member = std::make_shared<NodeListener>(nobody);
    nodes.join(member);
    return member;
  }
  void announces(const std::shared_ptr<NodeListener>& member, const Endpoint& endpoint) {
    nodes.announced(member, endpoint, known.endpoints());
  }
  /// Returns the news that were told to that member since the last call.
  std::vector<std::string> told(const std::shared_ptr<NodeListener>& member) {
    for (AddressedNews& one : nodes.take()) all.push_back(std::move(one));
    std::vector<std::string> texts;
    for (AddressedNews& one : all) {
      if (std::ranges::find(*one.to, member) == one.to->end()) continue;
      texts.push_back(text_of(one.news));
      auto rest = std::make_shared<NodeListeners>(*one.to);
      std::erase(*rest, member);
      one.to = std::move(rest);
    }
    return texts;
  }
  void remote_announces(Role role, EndpointId id, const std::string& topic = "points") {
    Endpoint e = endpoint(role, id, topic);
    e.node_id = remote_node;
    known.endpoint_came(remote, e, now);
    nodes.pass_on(known.take_news(), known.endpoints());
  }

  Deaf nobody;
  ProcessNodes nodes{5s};
  LinkMerge known;  ///< of other processes
  Time now{1h};
  const std::shared_ptr<NodeListener> first = joined(), second = joined(), third = joined();
  std::vector<AddressedNews> all;
};

TEST_F(ProcessNodesTest, IsToldOfWhatMayMatchItsOwnEndpoints) {
  announces(first, endpoint(Role::reader, 10));
  announces(second, endpoint(Role::writer, 20));
  announces(third, endpoint(Role::reader, 30, "scans"));
  EXPECT_THAT(told(first), ElementsAre("seen 20"));
  EXPECT_THAT(told(second), ElementsAre("seen 10"));
  remote_announces(Role::writer, 1);
  remote_announces(Role::reader, 2);
  remote_announces(Role::writer, 3, "scans");
  EXPECT_THAT(told(first), ElementsAre("seen 1"));
  EXPECT_THAT(told(second), ElementsAre("seen 2"));
  EXPECT_THAT(told(third), ElementsAre("seen 3"));
}

TEST_F(ProcessNodesTest, IsToldOfEverythingOfARoleThatItAsksFor) {
  announces(first, endpoint(Role::writer, 10));
  remote_announces(Role::writer, 1, "scans");
  nodes.hears_all(second, Role::writer, known.endpoints());
  EXPECT_THAT(told(second), ElementsAre("seen 10", "seen 1"));
  remote_announces(Role::writer, 2, "images");
  remote_announces(Role::reader, 3);
  announces(first, endpoint(Role::writer, 11, "masks"));
  EXPECT_THAT(told(second), ElementsAre("seen 2", "seen 11"));
  nodes.hears_all(second, Role::writer, known.endpoints());
  EXPECT_THAT(told(second), IsEmpty()) << "it is told once";
  nodes.hears_all(first, Role::reader, known.endpoints());
  EXPECT_THAT(told(first), ElementsAre("seen 3")) << "it knows already what concerns its own endpoint";
}

TEST_F(ProcessNodesTest, IsToldThatTheNodeOfAnEndpointIsSilent) {
  const Assertion sign{.node = remote_node, .writers = {}};
  remote_announces(Role::writer, 1);
  known.assertion_came(remote, sign, now);
  known.node_unheard(remote.link, remote_node, now += 1min);
  known.tick(now += 2min);
  nodes.hears_all(first, Role::writer, known.endpoints());
  EXPECT_THAT(told(first), ElementsAre("silent 1"));
  known.assertion_came(remote, sign, now);
  nodes.hears_all(second, Role::writer, known.endpoints());
  EXPECT_THAT(told(second), ElementsAre("seen 1")) << "it has returned";
}

TEST_F(ProcessNodesTest, IsToldWhatIsInForceOfATopicThatItHadNot) {
  announces(first, endpoint(Role::reader, 10));
  nodes.requested(request(10, 7));
  remote_announces(Role::reader, 1);
  known.request_came(remote, request(1, 8), now);
  known.endpoint_came(remote, endpoint(Role::reader, 2), now);
  known.endpoint_withdrawn(remote, 2, now);
  nodes.pass_on(known.take_news(), known.endpoints());
  EXPECT_THAT(told(second), ElementsAre("departed 2")) << "whom that concerned is not known any more";

  announces(second, endpoint(Role::writer, 20));
  EXPECT_THAT(told(second), ElementsAre("seen 10", "asked by 10: 7", "seen 1", "asked by 1: 8"));
  announces(second, endpoint(Role::writer, 21));
  EXPECT_THAT(told(second), IsEmpty());
}

TEST_F(ProcessNodesTest, ForgetsATopicThatItHasNoEndpointOfAnyMore) {
  announces(first, endpoint(Role::writer, 10));
  announces(first, endpoint(Role::writer, 11));
  announces(second, endpoint(Role::reader, 20));
  remote_announces(Role::reader, 1);
  EXPECT_THAT(told(first), ElementsAre("seen 20", "seen 1"));
  nodes.withdrawn(10, known.endpoints());
  EXPECT_THAT(told(first), IsEmpty());
  nodes.withdrawn(11, known.endpoints());
  EXPECT_THAT(told(first), UnorderedElementsAre("departed 1", "departed 20"));
  remote_announces(Role::reader, 2);
  EXPECT_THAT(told(first), IsEmpty());
  EXPECT_THAT(told(second), ElementsAre("seen 10", "seen 11", "departed 10", "departed 11"));
}

TEST_F(ProcessNodesTest, HearsWhatOthersSayInTheNameOfItsOwnEndpoints) {
  announces(first, endpoint(Role::writer, 10));
  announces(second, endpoint(Role::reader, 20));
  known.owns(10);
  (void)told(first), (void)told(second);
  remote_announces(Role::writer, 10, "something else");
  known.endpoint_withdrawn(remote, 10, now);
  nodes.pass_on(known.take_news(), known.endpoints());
  EXPECT_THAT(told(first), ElementsAre("seen 10", "departed 10"));
  EXPECT_THAT(told(second), IsEmpty());
}

TEST_F(ProcessNodesTest, HearsSignsOfLifeOfNodesWhoseEndpointsConcernIt) {
  announces(first, endpoint(Role::reader, 10));
  announces(second, endpoint(Role::writer, 20));
  announces(third, endpoint(Role::reader, 30, "scans"));
  remote_announces(Role::writer, 1);
  (void)told(first), (void)told(second), (void)told(third);
  known.assertion_came(remote, {.node = remote_node, .writers = {}}, now);
  nodes.pass_on(known.take_news(), known.endpoints());
  nodes.asserted(first, {.node = 1, .writers = {}}, now);
  EXPECT_THAT(told(first), ElementsAre("lives 77"));
  EXPECT_THAT(told(second), ElementsAre("lives 1"));
  EXPECT_THAT(told(third), IsEmpty());
}

// A tool asks about pairs, and has no endpoints.
TEST_F(ProcessNodesTest, HearsWhoAsksAboutItsEndpoints) {
  announces(first, endpoint(Role::reader, 10));
  announces(second, endpoint(Role::writer, 20));
  (void)told(first), (void)told(second);
  Assertion question{.node = remote_node, .writers = {}};
  question.asked_about = {20};
  known.assertion_came(remote, question, now);
  nodes.pass_on(known.take_news(), known.endpoints());
  question.node = 3;
  question.asked_about = {10};
  nodes.asserted(third, question, now);
  EXPECT_THAT(told(first), ElementsAre("lives 3"));
  EXPECT_THAT(told(second), ElementsAre("lives 77"));
}

TEST_F(ProcessNodesTest, MissesANodeOfItsProcessThatStandsStillUntilItGoesOn) {
  announces(first, endpoint(Role::writer, 10));
  announces(second, endpoint(Role::reader, 20));
  nodes.asserted(first, {.node = 1, .writers = {}}, now);
  (void)told(second);
  now += 5s;
  nodes.tick(now);
  EXPECT_THAT(told(second), IsEmpty());
  now += 1ms;
  nodes.tick(now);
  nodes.tick(now);
  EXPECT_THAT(told(second), ElementsAre("lost 10", "node lost 1"));
  EXPECT_THAT(told(third), ElementsAre("node lost 1"));
  announces(third, endpoint(Role::reader, 30));
  EXPECT_THAT(told(third), IsEmpty());
  nodes.asserted(first, {.node = 1, .writers = {}}, now);
  EXPECT_THAT(told(second), ElementsAre("seen 10", "lives 1"));
  EXPECT_THAT(told(third), ElementsAre("seen 10", "lives 1"));
}

TEST_F(ProcessNodesTest, RepeatsTheRequestOfANodeThatGoesOn) {
  announces(first, endpoint(Role::reader, 10));
  nodes.requested(request(10, 7));
  nodes.asserted(first, {.node = 1, .writers = {}}, now);
  EXPECT_THAT(nodes.living(now), ElementsAre(1));
  now += 6s;
  nodes.tick(now);
  EXPECT_THAT(nodes.living(now - 5s), IsEmpty()) << "nobody says in its name that it lives";
  announces(second, endpoint(Role::writer, 20));
  EXPECT_THAT(told(second), ElementsAre("node lost 1"));
  nodes.asserted(first, {.node = 1, .writers = {}}, now);
  EXPECT_THAT(told(second), ElementsAre("seen 10", "asked by 10: 7", "lives 1"));
}

TEST_F(ProcessNodesTest, MissesANodeOfItsProcessThatEnds) {
  announces(second, endpoint(Role::reader, 20));
  announces(first, endpoint(Role::writer, 10));
  nodes.asserted(first, {.node = 1, .writers = {}}, now);
  (void)told(second);
  EXPECT_THAT(nodes.endpoints_of(first), ElementsAre(10));
  nodes.withdrawn(10, known.endpoints());
  EXPECT_EQ(nodes.leave(first), 1U);
  EXPECT_EQ(nodes.leave(third), 0U) << "it has not said that it lives";
  EXPECT_THAT(told(second), ElementsAre("departed 10", "node lost 1"));
  EXPECT_THAT(nodes.living(now), IsEmpty());
}

}  // namespace
}  // namespace sft::core
