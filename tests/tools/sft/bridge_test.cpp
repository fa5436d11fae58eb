// The verb bridge between two domains on this host. tests/system/bridge_test.cpp tests bridges on two
// hosts.
#include <sft/json.h>
#include <sft/msg_text.h>
#include <algorithm>
#include <array>
#include <atomic>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <geometry_msgs/msg/PoseWithCovariance.hpp>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <std_msgs/msg/UInt32.hpp>

#include "tests/hostile/forged_control.h"
#include "tests/hostile/wire.h"
#include "tests/support/test_seed.h"
#include "tests/support/xyz_cloud.h"
#include "tests/tools/sft/tool_fixture.h"

namespace sft::test {
namespace {

using geometry_msgs::msg::PoseWithCovariance;
using std_msgs::msg::UInt32;
using ::testing::ElementsAre;
using ::testing::IsSupersetOf;
using ::testing::Not;

/// Collects the numbers that come to a topic, with the threads of a node.
class Listener {
 public:
  Listener(Node& node, const std::string& topic, SubscriberOptions options = {}) {
    options.depth = 1000;
    subscriber_ = node.subscriber<UInt32>(
                          topic,
                          [this](const auto& sample) {
                            const std::lock_guard lock(mutex_);
                            ++heard_[sample->data()];
                            last_ = sample->data();
                          },
                          options)
                      .value();
  }
  bool has(std::uint32_t number) {
    return eventually([&] {
      const std::lock_guard lock(mutex_);
      return heard_.contains(number);
    });
  }
  /// Waits until a number greater than this one comes.
  bool hears_more_than(std::uint32_t number) {
    return eventually([&] {
      const std::lock_guard lock(mutex_);
      return last_ > number;
    });
  }
  std::vector<std::uint32_t> numbers() {
    const std::lock_guard lock(mutex_);
    std::vector<std::uint32_t> all;
    for (const auto& [number, times] : heard_) all.push_back(number);
    return all;
  }
  /// The numbers that came more than once.
  std::set<std::uint32_t> repeated() {
    const std::lock_guard lock(mutex_);
    std::set<std::uint32_t> several;
    for (const auto& [number, times] : heard_) {
      if (times > 1) several.insert(number);
    }
    return several;
  }

 private:
  std::mutex mutex_;
  std::map<std::uint32_t, int> heard_;
  std::uint32_t last_ = 0;
  std::optional<Subscriber<UInt32>> subscriber_;
};

/// The memory that the process has written, and no file backs.
std::size_t anonymous_bytes(const ToolProcess& process) {
  std::ifstream status("/proc/" + std::to_string(process.id()) + "/status");
  std::size_t kilobytes = 0;
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("RssAnon:")) kilobytes = std::stoul(line.substr(8));
  }
  return kilobytes * 1024;
}

class BridgeTest : public ::testing::Test {
 protected:
  static Node open(std::uint32_t domain) {
    NodeOptions options{.name = "robot", .domain = domain, .transport = TransportChoice::udp};
    return Node::open(options).value();
  }
  using Bridge = std::unique_ptr<ToolProcess>;
  /// A bridge from one of the domains 41, 42 and 43 to another one.
  static Bridge bridge(std::uint32_t from, std::uint32_t to, std::vector<std::string> more) {
    std::vector<std::string> words{"bridge", "--from", std::to_string(from), "--to", std::to_string(to)};
    words.insert(words.end(), more.begin(), more.end());
    return std::make_unique<ToolProcess>(std::move(words));
  }
  static Ended end(const Bridge& bridge) {
    bridge->send(SIGINT);
    return bridge->end();
  }
  /// Waits until that number of bridges is in the node's domain.
  static bool has_bridges(Node& node, std::ptrdiff_t bridges) {
    return eventually([&] {
      return std::ranges::count(node.domain().publishers, "sft_bridges", &DomainSnapshot::Endpoint::topic) ==
             bridges;
    });
  }
};

TEST_F(BridgeTest, PartsOfAMessageAreAWholeMessageOnTheOtherSideWithTheTimeOfThePublisher) {
  Node here = open(41), there = open(42);
  auto publisher = here.publisher<PointCloud2>("points", {.reliability = reliable}).value();
  auto subscriber = there.subscriber<PointCloud2>("robot/points", {.reliability = reliable}).value();
  const Bridge work = bridge(41, 42, {"points{data{x,y,z}}[::4] -> robot/points"});
  ASSERT_TRUE(publisher.wait_for_subscribers(1, hang_timeout));
  const auto before = std::chrono::system_clock::now();
  publisher.publish(xyz_cloud(7));
  const auto after = std::chrono::system_clock::now();
  ASSERT_TRUE(subscriber.wait(hang_timeout));
  const auto sample = subscriber.take();
  EXPECT_EQ(sample->header().stamp().sec(), 7);
  EXPECT_EQ(sample->width(), points / 4);
  EXPECT_EQ(sample->point_step(), 12U);
  EXPECT_EQ(sample->row_step(), points / 4 * 12);
  EXPECT_EQ(sample->fields().size(), 3U);
  const auto data = sample->data();
  EXPECT_EQ(std::vector<std::uint8_t>(data.begin(), data.end()), thinned(xyz_cloud(7)));
  EXPECT_GE(sample.info().source_stamp, before);
  EXPECT_LE(sample.info().source_stamp, after) << "it is not the time of the bridge";
  const Ended ended = end(work);
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_THAT(ended.out, HasSubstr("1 sample carried"));
}

TEST_F(BridgeTest, CountsAreThoseOfTheirRuleAndItsMessages) {
  Node here = open(41), there = open(42);
  auto numbers = here.publisher<UInt32>("numbers", {.reliability = reliable}).value();
  auto back = there.publisher<UInt32>("back", {.reliability = reliable}).value();
  Listener heard(there, "robot/numbers", {.reliability = reliable}),
      heard_back(here, "back", {.reliability = reliable});
  const Bridge work = bridge(41, 42, {"numbers -> robot/numbers", "back <- back", "nobody", "--json"});
  ASSERT_TRUE(numbers.wait_for_subscribers(1, hang_timeout) && back.wait_for_subscribers(1, hang_timeout));
  for (const std::uint32_t number : {1U, 2U, 3U}) numbers.publish({.data = number});
  back.publish({.data = 4});
  ASSERT_TRUE(heard.has(3) && heard_back.has(4));
  const Ended ended = end(work);
  const Json summary = Json::parse(ended.out.substr(ended.out.rfind("{\"rules\"")));
  const auto counts = [](const char* rule, const char* from, int carried) {
    return Json{{"rule", rule},         {"from", from}, {"carried", carried},
                {"bytes", 8 * carried}, {"lost", 0},    {"refused", 0}};
  };
  EXPECT_EQ(summary["rules"],
            Json::array({counts("numbers -> robot/numbers", "domain 41", 3),
                         counts("back <- back", "domain 42", 1), counts("nobody", "domain 41", 0)}));
}

TEST_F(BridgeTest, SamplesThatWereLostOnTheWayToTheBridgeAreCounted) {
  NodeOptions options{.name = "robot", .domain = 41, .transport = TransportChoice::udp};
  options.udp.memory_limit_bytes = 4 << 20;
  Node here = Node::open(options).value(), there = open(42);
  auto publisher = here.publisher<PointCloud2>("points", {.reliability = reliable}).value();
  auto subscriber = there.subscriber<PointCloud2>("points", {.reliability = reliable}).value();
  const Bridge work = bridge(41, 42, {"points"});
  ASSERT_TRUE(publisher.wait_for_subscribers(1, hang_timeout));
  PointCloud2 too_large;
  too_large.data.resize(8'000'000);
  for (const std::int32_t number : {1, 2}) {
    publisher.publish(xyz_cloud(static_cast<std::uint32_t>(number)));
    ASSERT_TRUE(subscriber.wait(hang_timeout));
    const auto sample = subscriber.take();
    EXPECT_EQ(sample->header().stamp().sec(), number);
    EXPECT_EQ(publisher.publish(too_large), PublishStatus::no_memory);
  }
  const std::string summary = end(work).out;
  EXPECT_THAT(summary, HasSubstr(": 2 samples carried, "));
  EXPECT_THAT(summary, HasSubstr(", 1 lost, 0 refused"));
}

/// A new publisher is carried a second after its samples come by a subscription that is there already.
TEST_F(BridgeTest, OfSamplesThatComeBeforeTheirPublisherIsCarriedTheLastOnesAreKept) {
  Node here = open(41), there = open(42);
  auto first = here.publisher<PointCloud2>("points", {.reliability = reliable}).value();
  const Bridge work = bridge(41, 42, {"points"});
  std::mutex mutex;
  std::set<std::int32_t> came;
  const auto hear = [&](const auto& sample) {
    const std::lock_guard lock(mutex);
    came.insert(sample->header().stamp().sec());
  };
  const auto subscriber =
      there.subscriber<PointCloud2>("points", hear, {.reliability = reliable, .depth = 1000}).value();
  ASSERT_TRUE(first.wait_for_subscribers(1, hang_timeout));
  auto second = here.publisher<PointCloud2>("points", {.reliability = reliable}).value();
  ASSERT_TRUE(second.wait_for_subscribers(1, hang_timeout));
  constexpr std::int32_t clouds = 150, surely_kept = 40;  // 64 kB each, and 4 MiB are kept
  Pace pace(3ms);
  for (std::int32_t number = 1; number <= clouds; ++number) {
    second.publish(xyz_cloud(static_cast<std::uint32_t>(number)));
    pace.await_turn();
  }
  EXPECT_TRUE(eventually([&] {
    const std::lock_guard lock(mutex);
    return came.contains(clouds);
  }));
  const std::lock_guard lock(mutex);
  EXPECT_EQ(std::distance(came.upper_bound(clouds - surely_kept), came.end()), surely_kept);
}

TEST_F(BridgeTest, LateReadersGetWhatEachPublisherRetains) {
  Node here = open(41), there = open(42);
  const auto latched = [&](std::uint32_t depth) {
    return here
        .publisher<UInt32>("map",
                           {.reliability = reliable, .durability = transient_local, .history_depth = depth})
        .value();
  };
  auto one = latched(2), other = latched(1);
  for (const std::uint32_t number : {1U, 2U, 3U}) one.publish({.data = number});
  for (const std::uint32_t number : {11U, 12U}) other.publish({.data = number});
  const Bridge work = bridge(41, 42, {"map"});
  const SubscriberOptions late{.reliability = reliable, .durability = transient_local};
  Listener first(there, "map", late);
  EXPECT_TRUE(first.has(2) && first.has(3) && first.has(12));
  Listener second(there, "map", late);
  EXPECT_TRUE(second.has(2) && second.has(3) && second.has(12));
  one.publish({.data = 4});
  EXPECT_TRUE(first.has(4) && second.has(4));
  EXPECT_THAT(first.numbers(), ElementsAre(2, 3, 4, 12));
  EXPECT_THAT(second.numbers(), ElementsAre(2, 3, 4, 12));
  EXPECT_THAT(first.repeated(), ElementsAre());
  EXPECT_THAT(second.repeated(), ElementsAre());
}

TEST_F(BridgeTest, ThreeBridgesInARingGiveEachReaderEachSampleOnceWhicheverOfThemStartsAnew) {
  constexpr std::array<std::uint32_t, 3> domains{41, 42, 43};
  Node a = open(41), b = open(42), c = open(43);
  auto publisher = a.publisher<UInt32>("chatter", {.reliability = reliable}).value();
  Listener at_a(a, "chatter"), at_b(b, "chatter"), at_c(c, "chatter");
  std::atomic<std::uint32_t> published{0};
  const auto start = [&](std::size_t i) {
    return bridge(domains[i], domains[(i + 1) % 3], {"chatter <-> chatter"});
  };
  std::array<Bridge, 3> bridges{start(0), start(1), start(2)};
  const Ticker ticker(10ms, [&](std::uint32_t number) {
    publisher.publish({.data = number});
    published = number;
  });
  EXPECT_TRUE(at_b.hears_more_than(0) && at_c.hears_more_than(0));
  for (std::size_t i = 0; i < 6; ++i) {
    Bridge& one = bridges[i % 3];
    EXPECT_EQ(end(one).code < 2, true);
    const std::uint32_t at_end = published;
    EXPECT_TRUE(at_b.hears_more_than(at_end) && at_c.hears_more_than(at_end)) << "the others carry both ways";
    one = start(i % 3);
    const std::uint32_t at_start = published + 200;
    EXPECT_TRUE(at_a.hears_more_than(at_start) && at_b.hears_more_than(at_start) &&
                at_c.hears_more_than(at_start));
  }
  EXPECT_THAT(at_a.repeated(), ElementsAre());
  EXPECT_THAT(at_b.repeated(), ElementsAre());
  EXPECT_THAT(at_c.repeated(), ElementsAre());
}

TEST_F(BridgeTest, FieldsThatAMessageCannotLackAreSelectedOrNamedAsDefaults) {
  Node here = open(41), there = open(42);
  auto publisher = here.publisher<PoseWithCovariance>("pose", {.reliability = reliable}).value();
  const Ended refused = bridge(41, 42, {"pose{pose}"})->end();
  EXPECT_EQ(refused.code, 2);
  EXPECT_THAT(refused.err, HasSubstr("cannot lack 'covariance': select it, or name it in --defaults"));

  auto subscriber = there.subscriber<PoseWithCovariance>("pose", {.reliability = reliable}).value();
  const Bridge work = bridge(41, 42, {"pose{pose}", "--defaults", "covariance"});
  ASSERT_TRUE(publisher.wait_for_subscribers(1, hang_timeout));
  PoseWithCovariance message;
  message.pose.position.x = 0.1;
  message.covariance.fill(3);
  publisher.publish(message);
  ASSERT_TRUE(subscriber.wait(hang_timeout));
  const auto sample = subscriber.take();
  EXPECT_EQ(sample->pose().position().x(), 0.1);
  EXPECT_EQ(sample->covariance()[0], 0);
}

TEST_F(BridgeTest, ATopicWithoutARuleOrAReaderIsNotSubscribedTo) {
  Node here = open(41), there = open(42);
  auto denied = here.publisher<UInt32>("denied").value();
  auto unread = here.publisher<UInt32>("unread").value();
  auto wanted = here.publisher<UInt32>("wanted").value();
  Listener also_denied(there, "denied"), also_wanted(there, "wanted");
  const Bridge work = bridge(41, 42, {"wanted", "unread", "--json"});
  ASSERT_TRUE(wanted.wait_for_subscribers(1, hang_timeout));
  ASSERT_TRUE(work->says("'unread' has no subscriber on side 'domain 42' yet"));
  EXPECT_THAT(denied.status().readers, ElementsAre());
  EXPECT_THAT(unread.status().readers, ElementsAre());
}

TEST_F(BridgeTest, ARuleThatMeetsNothingIsNamedWithTheNearestTopic) {
  Node here = open(41);
  auto publisher = here.publisher<UInt32>("points").value();
  const std::string sentence = "topic 'point' has no publisher on side 'domain 41' yet";
  const Bridge work = bridge(41, 42, {"point -> robot/points", "--json"});
  ASSERT_TRUE(work->says("rule 'point -> robot/points': " + sentence));
  ASSERT_TRUE(work->prints("{\"time_s\":7."));
  const std::string said = end(work).err;
  EXPECT_THAT(said, HasSubstr("points"));
  EXPECT_EQ(said.find(sentence), said.rfind(sentence)) << "it is named once";
}

TEST_F(BridgeTest, PatternsCarryTheTopicsOfANamespaceIntoAnother) {
  Node here = open(41), there = open(42);
  auto left = here.publisher<UInt32>("camera/left", {.reliability = reliable}).value();
  auto tf = there.publisher<UInt32>("station/tf", {.reliability = reliable}).value();
  const Bridge work = bridge(41, 42, {"camera/* -> robot/camera/*", "* <- station/*"});
  Listener heard(there, "robot/camera/left", {.reliability = reliable}),
      back(here, "tf", {.reliability = reliable});
  ASSERT_TRUE(left.wait_for_subscribers(1, hang_timeout) && tf.wait_for_subscribers(1, hang_timeout));
  left.publish({.data = 1});
  tf.publish({.data = 2});
  EXPECT_TRUE(heard.has(1) && back.has(2));
}

TEST_F(BridgeTest, ATopicThatComesBackWithAnotherTypeIsCarried) {
  Node here = open(41), there = open(42);
  const Bridge work = bridge(41, 42, {"data"});
  for (std::uint32_t i = 1; i <= 3; ++i) {
    {
      auto numbers = here.publisher<UInt32>("data", {.reliability = reliable}).value();
      Listener heard(there, "data", {.reliability = reliable});
      ASSERT_TRUE(numbers.wait_for_subscribers(1, hang_timeout));
      numbers.publish({.data = i});
      EXPECT_TRUE(heard.has(i));
    }
    auto poses = here.publisher<PoseWithCovariance>("data", {.reliability = reliable}).value();
    auto subscriber = there.subscriber<PoseWithCovariance>("data", {.reliability = reliable}).value();
    ASSERT_TRUE(poses.wait_for_subscribers(1, hang_timeout));
    poses.publish({});
    EXPECT_TRUE(subscriber.wait(hang_timeout));
  }
}

TEST_F(BridgeTest, APatternCarriesSixtyFourTopics) {
  Node here = open(41), there = open(42);
  const Bridge work = bridge(41, 42, {"sensors/* -> robot/*"});
  std::vector<Publisher<UInt32>> publishers;
  std::vector<std::unique_ptr<Listener>> listeners;
  for (std::uint32_t i = 0; i < 64; ++i) {
    const std::string name = "s" + std::to_string(i);
    publishers.push_back(here.publisher<UInt32>("sensors/" + name, {.reliability = reliable}).value());
    listeners.push_back(
        std::make_unique<Listener>(there, "robot/" + name, SubscriberOptions{.reliability = reliable}));
  }
  for (std::uint32_t i = 0; i < 64; ++i) {
    ASSERT_TRUE(publishers[i].wait_for_subscribers(1, hang_timeout)) << i;
    publishers[i].publish({.data = i});
  }
  for (std::uint32_t i = 0; i < 64; ++i) EXPECT_TRUE(listeners[i]->has(i)) << i;
}

/// A bridge carries a topic on which the samples are counted, from domain 41 to domain 0.
class CarryingBridgeTest : public BridgeTest {
 protected:
  static Bridge like_it() { return bridge(41, 0, {"chatter"}); }
  bool is_carried() { return heard_.hears_more_than(0); }
  /// Waits until it is clear that what is published now comes.
  bool is_carried_again() { return heard_.hears_more_than(published_ + 100); }
  static const char* waits() { return "another bridge carries 'chatter' to side 'domain 0'; this one waits"; }

  Node here_ = open(41), there_ = open(0);
  Publisher<UInt32> publisher_ = here_.publisher<UInt32>("chatter", {.reliability = reliable}).value();
  Listener heard_{there_, "chatter", {.reliability = reliable}};
  Bridge bridge_ = like_it();
  std::atomic<std::uint32_t> published_{0};
  Ticker ticker_{10ms, [this](std::uint32_t number) {
                   publisher_.publish({.data = number});
                   published_ = number;
                 }};
};

TEST_F(CarryingBridgeTest, OfTwoBridgesSideBySideOneWaitsSaysSoAndTakesOver) {
  ASSERT_TRUE(is_carried());
  const Bridge second = like_it();
  ASSERT_TRUE(second->says(waits()));
  EXPECT_EQ(end(bridge_).code, 0);
  EXPECT_TRUE(is_carried_again());
  EXPECT_EQ(end(second).code, 0);
  EXPECT_THAT(heard_.repeated(), ElementsAre());
}

TEST_F(CarryingBridgeTest, WhenABridgeIsKilledAnotherTakesOverAndNobodyGetsASampleTwice) {
  ASSERT_TRUE(is_carried());
  const Bridge second = like_it();
  ASSERT_TRUE(second->says(waits()));
  bridge_->send(SIGKILL);
  EXPECT_EQ(bridge_->end().code, -SIGKILL);
  EXPECT_TRUE(is_carried_again());
  EXPECT_EQ(end(second).code, 0);
  EXPECT_THAT(heard_.repeated(), ElementsAre());
}

TEST_F(CarryingBridgeTest, OfManyBridgesOneCarriesWhicheverOfThemEnds) {
  std::vector<Bridge> others;
  for (std::uint64_t i = 0; i < test_rounds(7); ++i) others.push_back(like_it());
  ASSERT_TRUE(has_bridges(there_, static_cast<std::ptrdiff_t>(others.size()) + 1));
  ASSERT_TRUE(is_carried());
  EXPECT_LT(end(bridge_).code, 2);
  while (others.size() > 1) {
    ASSERT_TRUE(is_carried_again()) << others.size();
    EXPECT_LT(end(others.back()).code, 2);
    others.pop_back();
  }
  EXPECT_TRUE(is_carried_again());
  EXPECT_THAT(heard_.repeated(), ElementsAre());
}

TEST_F(CarryingBridgeTest, FiftyRestartsOfAnotherBridgeCostNoSampleAndNoMemory) {
  ASSERT_TRUE(is_carried());
  std::size_t before = 0;
  for (int i = 0; i < 50; ++i) {
    const Bridge other = like_it();
    ASSERT_TRUE(has_bridges(there_, 2));
    EXPECT_LT(end(other).code, 2);
    ASSERT_TRUE(has_bridges(there_, 1));
    if (i == 9) before = anonymous_bytes(*bridge_);
  }
  EXPECT_LT(anonymous_bytes(*bridge_), before + 4'000'000);
  const std::vector<std::uint32_t> numbers = heard_.numbers();
  EXPECT_EQ(numbers.back() - numbers.front() + 1, numbers.size()) << "some are missing";
  EXPECT_THAT(heard_.repeated(), ElementsAre());
}

/// The announcement of a bridge that was started before all others.
Json announcement(const Json& routes) { return {{"bridge", 1}, {"routes", routes}}; }
/// The route of a publisher that is as far from its origin as with the bridge of the test.
Json route_of_chatter(std::uint64_t origin) {
  return {{"origin", origin}, {"bridges", 1}, {"topic", "chatter"}, {"publisher", 1}};
}
DynamicType type_of_routes() {
  return from_msg("sft_bridge/Routes",
                  "uint64 bridge\nsft_bridge/Route[] routes\n===\nMSG: sft_bridge/Route\nuint64 origin\n"
                  "uint32 bridges\nstring topic\nuint64 publisher\n")
      .value();
}

/// A node that announces itself as a bridge, with the routes that the test gives it.
class FalseBridge {
 public:
  explicit FalseBridge(std::uint32_t domain = 0)
      : node_(Node::open({.name = "sft_bridge_1", .domain = domain, .transport = TransportChoice::udp})
                  .value()) {}
  void announce_itself(std::uint64_t origin) { announce(Json::array({route_of_chatter(origin)})); }
  /// The route says that `publisher` brings samples of `origin`. It is announced to bridges that come later.
  void announce_route(std::uint64_t publisher, std::uint64_t origin) {
    announce({{{"origin", origin}, {"bridges", 1}, {"topic", "chatter"}, {"publisher", publisher}}}, false);
  }
  void announce_many(std::size_t routes, std::size_t topic_bytes) {
    Json list = Json::array();
    for (std::size_t i = 0; i < routes; ++i)
      list.push_back(
          {{"origin", i}, {"bridges", 1}, {"topic", std::string(topic_bytes, 'x')}, {"publisher", i}});
    announce(list);
  }

 private:
  void announce(const Json& routes, bool waits_for_bridge = true) {
    publishers_.push_back(
        node_
            .publisher("sft_bridges", type_of_routes(),
                       {.reliability = reliable, .durability = transient_local, .max_sample_bytes = 16 << 20})
            .value());
    EXPECT_TRUE(!waits_for_bridge || publishers_.back().wait_for_subscribers(1, hang_timeout));
    EXPECT_TRUE(publishers_.back().publish_json(announcement(routes).dump()));
  }

  Node node_;
  std::vector<DynamicPublisher> publishers_;
};

TEST_F(BridgeTest, NobodyHasRoutesForThePublishersOfOthers) {
  Node here = open(41), there = open(42);
  auto publisher = here.publisher<UInt32>("chatter", {.reliability = reliable}).value();
  auto other = there.publisher<UInt32>("chatter", {.reliability = reliable}).value();
  Listener heard(there, "chatter", {.reliability = reliable});
  FalseBridge attacker(41);
  attacker.announce_route(publisher.status().id, other.status().id);
  const Bridge work = bridge(41, 42, {"chatter"});
  ASSERT_TRUE(publisher.wait_for_subscribers(1, hang_timeout)) << "it does not belong to the other side";
  publisher.publish({.data = 7});
  EXPECT_TRUE(heard.has(7));
}

TEST_F(CarryingBridgeTest, FalseRoutesCostLittleMemoryAndCountOnlyWhileTheirPublishersAreThere) {
  ASSERT_TRUE(is_carried());
  const std::size_t before = anonymous_bytes(*bridge_);
  {
    FalseBridge attacker;
    attacker.announce_many(100'000, 1);
    for (int i = 0; i < 40; ++i) attacker.announce_many(900, 200);
    attacker.announce_itself(publisher_.status().id);
    EXPECT_TRUE(bridge_->says(waits()));
  }
  EXPECT_TRUE(is_carried_again());
  EXPECT_LT(anonymous_bytes(*bridge_), before + 40'000'000);
  EXPECT_EQ(end(bridge_).code, 0);
  EXPECT_THAT(heard_.repeated(), ElementsAre());
}

/// Sends datagrams to a bridge in domain 0 in the name of another one.
class RouteForger {
 public:
  RouteForger(const ToolProcess& to, const ToolProcess& in_the_name_of)
      : reader_(endpoint_of(core::Role::reader, to)),
        writer_(endpoint_of(core::Role::writer, in_the_name_of)) {}
  bool knows_both() const { return reader_.id != 0 && writer_.id != 0; }

  void send(const Json& announcement) {
    const std::vector<std::byte> cdr = cdr_from_json(type_of_routes().type(), announcement.dump()).value();
    const std::span<const std::byte> body = std::span(cdr).subspan(4);
    udp::FirstHeader header;
    header.label = {static_cast<std::uint32_t>(writer_.id), ++sequence_, 60'000};
    header.mask = reader_.request.mask_words.empty() ? 0 : reader_.request.mask_words[0];
    header.total = static_cast<std::uint32_t>(body.size());
    header.stamp_ns = std::chrono::system_clock::now().time_since_epoch().count();
    hostile::Bytes datagram = hostile::encoded(header, header.bytes());
    datagram.insert(datagram.end(), body.begin(), body.end());
    for (const sockaddr_in& address : hostile::addresses_of(reader_)) sender_.send(datagram, address);
  }

 private:
  core::Endpoint endpoint_of(core::Role role, const ToolProcess& bridge) {
    core::Endpoint found;
    eventually([&] {
      for (const core::Endpoint& one : control_.heard(role)) {
        const bool has_request = role == core::Role::writer || !one.request.mask_words.empty();
        if (one.topic == "sft_bridges" && one.node == "sft_bridge_" + std::to_string(bridge.id()) &&
            has_request)
          found = one;
      }
      return found.id != 0;
    });
    return found;
  }

  hostile::ForgedControl control_{0, {"lo"}};
  hostile::Sender sender_;
  core::Endpoint reader_, writer_;
  std::uint32_t sequence_ = 500;  ///< above what an honest bridge has reached
};

TEST_F(CarryingBridgeTest, RoutesThatAreForgedInTheNameOfABridgeHoldUntilItAnnouncesItsOwnAgain) {
  ASSERT_TRUE(is_carried());
  const Bridge other = bridge(43, 0, {"nothing"});
  ASSERT_TRUE(has_bridges(there_, 2));
  RouteForger forger(*bridge_, *other);
  ASSERT_TRUE(forger.knows_both());
  {
    const Json forged = announcement(Json::array({route_of_chatter(publisher_.status().id)}));
    const Ticker forging(100ms, [&](std::uint32_t) { forger.send(forged); });
    ASSERT_TRUE(bridge_->says(waits()));
  }
  EXPECT_TRUE(is_carried_again());
  EXPECT_THAT(heard_.repeated(), ElementsAre());
}

}  // namespace
}  // namespace sft::test
