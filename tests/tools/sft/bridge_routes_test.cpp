// Which bridge of a domain carries a publisher, as a function of the announcements, the domain and the time.
// The test makes the domain and the time.
#include "tools/sft/bridge_routes.h"

#include <gmock/gmock.h>
#include <sft/msg_text.h>

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tests/support/eventually.h"

namespace sft::tool {
namespace {

using namespace std::chrono_literals;
using test::eventually;
using Json = nlohmann::json;
using Route = BridgeRoutes::Route;
using Verdict = BridgeRoutes::Verdict;

/// A publisher of the topic of bridges in another node, which announces what the test wants.
class OtherBridge {
 public:
  explicit OtherBridge(std::uint64_t number)
      : number_(number),
        node_(Node::open({.name = "sft_bridge_2", .domain = 44, .transport = TransportChoice::udp}).value()),
        publisher_(node_
                       .publisher(bridge_topic,
                                  from_msg("sft_bridge/Routes",
                                           "uint64 bridge\nsft_bridge/Route[] routes\n===\n"
                                           "MSG: sft_bridge/Route\nuint64 origin\nuint32 bridges\n"
                                           "string topic\nuint64 publisher\n")
                                      .value(),
                                  {.reliability = reliable, .durability = transient_local})
                       .value()) {
    EXPECT_TRUE(publisher_.wait_for_subscribers(1, test::hang_timeout));
  }
  void announce(const std::vector<Route>& routes) {
    Json list = Json::array();
    for (const Route& route : routes)
      list.push_back({{"origin", route.origin},
                      {"bridges", route.bridges},
                      {"topic", route.topic},
                      {"publisher", route.publisher}});
    EXPECT_TRUE(publisher_.publish_json(Json{{"bridge", number_}, {"routes", list}}.dump()));
  }
  /// Its publisher as the domain of the bridge has it.
  DomainSnapshot::Endpoint endpoint() const {
    DomainSnapshot::Endpoint endpoint;
    endpoint.id = publisher_.status().id;
    endpoint.node_id = 2;
    endpoint.node = "sft_bridge_2";
    endpoint.topic = bridge_topic;
    return endpoint;
  }

 private:
  std::uint64_t number_;
  Node node_;
  DynamicPublisher publisher_;
};

/// Bridge number 100, which may carry samples of the origin 7 to the topic "t".
class BridgeRoutesTest : public ::testing::Test {
 protected:
  static constexpr BridgeRoutes::Source origin{.origin = 7, .bridges = 0};

  static Route route(std::uint32_t bridges, std::uint64_t publisher, std::uint64_t of = 7,
                     const char* topic = "t") {
    return {.origin = of, .bridges = bridges, .topic = topic, .publisher = publisher};
  }
  Verdict verdict(std::chrono::milliseconds at, const BridgeRoutes::Source& source = origin) {
    return routes.verdict(source, "t", begin + at);
  }
  void look(std::chrono::milliseconds at) { routes.look(domain, begin + at); }
  void announce(std::chrono::milliseconds at, std::vector<Route> own) {
    routes.announce(std::move(own), begin + at);
  }
  void is_there(const OtherBridge& other) { domain.publishers = {other.endpoint()}; }
  /// Waits until the announcements of others have led to this verdict at that time.
  bool comes_to(Verdict expected, std::chrono::milliseconds at, const BridgeRoutes::Source& source = origin) {
    return eventually([&] {
      look(at);
      return verdict(at, source) == expected;
    });
  }
  std::uint64_t announcements() const { return node.snapshot().publishers.at(0).published; }

  const BridgeRoutes::Time begin = std::chrono::steady_clock::now();
  Node node = Node::open({.name = "sft_bridge_1", .domain = 44, .transport = TransportChoice::udp}).value();
  BridgeRoutes routes = BridgeRoutes::open(node, 100).value();
  DomainSnapshot domain;
};

TEST_F(BridgeRoutesTest, AloneABridgeCarriesAtOnceButOnlyAfterItHasHadTimeToFindOthers) {
  look(0ms);
  EXPECT_EQ(verdict(100s), Verdict::settles) << "the route was not announced";
  announce(500ms, {route(1, 0)});
  EXPECT_EQ(verdict(1499ms), Verdict::settles);
  announce(1400ms, {route(1, 0), route(1, 0, 8)});
  EXPECT_EQ(verdict(1500ms), Verdict::holds) << "a second after its first announcement";
  EXPECT_EQ(routes.verdict({.origin = 8}, "t", begin + 1500ms), Verdict::settles);
  announce(2s, {});
  EXPECT_EQ(verdict(2s), Verdict::settles) << "it was taken back";
  announce(2s, {route(1, 0)});
  EXPECT_EQ(verdict(2500ms), Verdict::settles);
  announce(60s, {route(1, 0), route(1, 0, 8)});
  EXPECT_EQ(routes.verdict({.origin = 8}, "t", begin + 60s), Verdict::holds) << "nobody else is there";
  EXPECT_EQ(routes.verdict({.origin = 8}, "u", begin + 60s), Verdict::settles) << "that is another topic";
}

TEST_F(BridgeRoutesTest, ABridgeThatIsDiscoveredIsWaitedForUntilItsRoutesComeOrFiveSecondsHavePassed) {
  DomainSnapshot::Endpoint silent;
  silent.id = 5;
  silent.topic = bridge_topic;
  domain.publishers = {silent};
  announce(0ms, {route(1, 0)});
  look(10s);
  EXPECT_EQ(verdict(14999ms), Verdict::settles);
  EXPECT_EQ(verdict(15s), Verdict::holds);
  look(14s);
  EXPECT_EQ(verdict(15s), Verdict::holds) << "it is waited for since it was first there";
  domain.publishers = {};
  look(20s);
  domain.publishers = {silent};
  look(30s);
  EXPECT_EQ(verdict(34999ms), Verdict::settles) << "it has come again";
}

TEST_F(BridgeRoutesTest, ARouteInUseOfABridgeThatIsThereHolds) {
  OtherBridge other(200);
  is_there(other);
  announce(0ms, {route(1, 0)});
  other.announce({route(1, 9)});
  EXPECT_TRUE(comes_to(Verdict::held_by_another, 10s));
  EXPECT_EQ(routes.verdict({.origin = 8}, "t", begin + 10s), Verdict::settles) << "another origin";
  EXPECT_EQ(routes.verdict(origin, "u", begin + 10s), Verdict::settles) << "another topic";
  domain.publishers = {};
  look(11s);
  EXPECT_EQ(verdict(11s), Verdict::holds) << "it has gone";
  is_there(other);
  look(20s);
  EXPECT_EQ(verdict(20s), Verdict::held_by_another)
      << "it is back, and does not announce its old routes again";
  domain.publishers = {};
  look(20s + 1h);
  is_there(other);
  look(20s + 1h);
  EXPECT_EQ(verdict(20s + 1h), Verdict::held_by_another);
  domain.publishers = {};
  look(20s + 2h + 1ms);
  is_there(other);
  look(20s + 2h + 1ms);
  EXPECT_EQ(verdict(30s + 2h), Verdict::holds) << "it was away for more than an hour, and is forgotten";
}

TEST_F(BridgeRoutesTest, WhoHasFewerBridgesOrStartedEarlierCarries) {
  OtherBridge later(200);
  is_there(later);
  announce(0ms, {route(2, 0)});
  const BridgeRoutes::Source near{.origin = 7, .bridges = 0}, far{.origin = 7, .bridges = 1};
  later.announce({route(1, 0)});
  EXPECT_TRUE(comes_to(Verdict::held_by_another, 10s, far)) << "two bridges against one";
  EXPECT_EQ(verdict(10s, near), Verdict::holds) << "one against one, and it started later";
  later.announce({route(3, 0)});
  EXPECT_TRUE(comes_to(Verdict::holds, 10s, far));
  OtherBridge earlier(50);
  is_there(earlier);
  earlier.announce({route(2, 0)});
  EXPECT_TRUE(comes_to(Verdict::held_by_another, 11s, far)) << "two against two";
  EXPECT_EQ(verdict(11s, near), Verdict::holds);
}

TEST_F(BridgeRoutesTest, ARouteInUseGivesWayToABetterOneOnly) {
  OtherBridge other(200);
  is_there(other);
  announce(0ms, {route(2, 5)});
  const BridgeRoutes::Source far{.origin = 7, .bridges = 1};
  look(10s);
  EXPECT_EQ(verdict(10s, far), Verdict::holds);
  other.announce({route(2, 9), route(0, 0, 77)});
  ASSERT_TRUE(eventually([&] {
    look(10s);
    return routes.verdict({.origin = 77}, "t", begin + 10s) == Verdict::belongs_there;
  }));
  EXPECT_EQ(verdict(10s, far), Verdict::holds) << "the other one ends its route";
  other.announce({route(1, 9)});
  EXPECT_TRUE(comes_to(Verdict::held_by_another, 10s, far));
}

TEST_F(BridgeRoutesTest, SamplesAreNotCarriedToWhereTheirOriginIs) {
  announce(0ms, {route(1, 0)});
  look(10s);
  EXPECT_EQ(verdict(10s), Verdict::holds);
  DomainSnapshot::Endpoint publisher;
  publisher.id = 7;
  domain.publishers = {publisher};
  look(10s);
  EXPECT_EQ(verdict(10s), Verdict::belongs_there);
  domain.publishers = {};
  look(10s);
  announce(11s, {route(1, 0), route(0, 0, 7, "of_dds")});
  EXPECT_EQ(verdict(11s), Verdict::belongs_there) << "this bridge has found the origin there itself";
}

TEST_F(BridgeRoutesTest, OnlyABridgesOwnPublishersHaveTheOriginThatItAnnounces) {
  OtherBridge other(200);
  is_there(other);
  DomainSnapshot::Endpoint carried;
  carried.id = 9;
  carried.node_id = 2;
  carried.node = "sft_bridge_2";
  EXPECT_FALSE(routes.source_of(carried)) << "its route is not known yet";
  other.announce({route(3, 9, 77), route(0, 10, 78)});
  ASSERT_TRUE(eventually([&] {
    look(10s);
    return routes.source_of(carried).has_value();
  }));
  EXPECT_EQ(routes.source_of(carried)->origin, 77U);
  EXPECT_EQ(routes.source_of(carried)->bridges, 3U);
  DomainSnapshot::Endpoint unknown = carried;
  unknown.id = 10;
  EXPECT_FALSE(routes.source_of(unknown)) << "a route of no bridges is that of a DDS writer";
  DomainSnapshot::Endpoint of_robot = carried;
  of_robot.node_id = 3;
  of_robot.node = "robot";
  EXPECT_EQ(routes.source_of(of_robot)->origin, 9U);
  EXPECT_EQ(routes.source_of(of_robot)->bridges, 0U);
  domain.publishers = {};
  look(20s);
  EXPECT_FALSE(routes.source_of(carried)) << "the bridge has gone";
}

TEST_F(BridgeRoutesTest, RoutesAreAnnouncedWhenTheyChangeAndElseEveryTwoSeconds) {
  EXPECT_EQ(announcements(), 1U) << "it has no routes at first, and says so";
  announce(10s, {route(1, 0), route(1, 0, 8)});
  EXPECT_EQ(announcements(), 2U);
  announce(11999ms, {route(1, 0, 8), route(1, 0)});
  EXPECT_EQ(announcements(), 2U) << "the order means nothing";
  announce(12s, {route(1, 0), route(1, 0, 8)});
  EXPECT_EQ(announcements(), 3U);
  announce(12100ms, {route(1, 5), route(1, 0, 8)});
  EXPECT_EQ(announcements(), 4U);
  announce(14s, {route(1, 5), route(1, 0, 8)});
  EXPECT_EQ(announcements(), 4U) << "the pause begins with each announcement";
  announce(14100ms, {route(1, 5), route(1, 0, 8)});
  EXPECT_EQ(announcements(), 5U);
  std::vector<Route> many(2000, route(1, 0, 7, "a_name_of_a_topic_with_many_characters"));
  announce(20s, many);
  EXPECT_EQ(announcements(), 6U);
  announce(22s, many);
  EXPECT_EQ(announcements(), 6U) << "long lists are announced less often";
  announce(60s, many);
  EXPECT_EQ(announcements(), 7U);
}

TEST_F(BridgeRoutesTest, ChainsAndNamesThatAreTooLongCountForNothing) {
  OtherBridge other(50);
  is_there(other);
  announce(0ms, {route(1, 0)});
  const std::string longest(255, 'x'), too_long(256, 'x');
  other.announce(
      {route(65, 9), route(0, 0, 10, too_long.c_str()), route(64, 9, 8), route(0, 0, 11, longest.c_str())});
  ASSERT_TRUE(eventually([&] {
    look(10s);
    return routes.verdict({.origin = 11}, "t", begin + 10s) == Verdict::belongs_there;
  }));
  EXPECT_EQ(verdict(10s), Verdict::holds);
  EXPECT_EQ(routes.verdict({.origin = 8}, "t", begin + 10s), Verdict::held_by_another);
  EXPECT_EQ(routes.verdict({.origin = 10}, "t", begin + 10s), Verdict::settles);
}

}  // namespace
}  // namespace sft::tool
