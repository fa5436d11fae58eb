#include "udp_transport/routing/routes.h"

#include <gtest/gtest.h>

#include <set>
#include <vector>

#include "tests/unit/udp/connections.h"
#include "tests/unit/udp/messages.h"
#include "udp_transport/flow/destination_directory.h"

namespace sft::udp {
namespace {

using namespace detail;

using test::fields;
using test::Image;
using test::Wide;

class RoutesTest : public testing::Test {
 protected:
  static core::Route route(std::uint16_t port, const FieldMask& mask) {
    return {port, core::UdpAddress{0x7f000001, port, 1'000'000}, mask};
  }
  template <class T = Image>
  std::shared_ptr<const RouteTable> table(const std::vector<core::Route>& routes) {
    return make_route_table(type_support<T>(), routes, variants_, destinations_);
  }
  /// Returns a different mask for each number.
  static FieldMask mask(std::uint64_t number) { return FieldMask::from_words(64, {&number, 1}); }

  VariantDirectory variants_{8, std::make_shared<WriterTally>()};
  test::Connections connections_;
  DestinationDirectory destinations_{DestinationLimits{}, connections_.connect()};
};

TEST_F(RoutesTest, GroupsReadersByMaskAndMaskReadersByAddress) {
  const auto t = table({route(1, fields<Image>("data")), route(2, fields<Image>("name")),
                        route(3, fields<Image>("data")), route(1, fields<Image>("data"))});
  ASSERT_EQ(t->audiences.size(), 2U);
  EXPECT_EQ(t->audiences[0].lanes.size(), 2U);
  EXPECT_EQ(t->audiences[1].lanes.size(), 1U);
  EXPECT_NE(t->audiences[0].wire->variant, t->audiences[1].wire->variant);
}

TEST_F(RoutesTest, FallbackRoutesComeLastAndShareNumbersAndLanesWithOthers) {
  const FieldMask data = fields<Image>("data");
  core::Route fallback = route(2, data), beside = route(1, data);
  fallback.fallback = beside.fallback = true;
  beside.reader = 7;
  const auto t = table({fallback, beside, route(1, data)});
  EXPECT_EQ(t->reached(core::Reach::usual_routes).size(), 1U);
  ASSERT_EQ(t->reached(core::Reach::fallback_routes_too).size(), 2U);
  EXPECT_EQ(t->audiences[1].wire, t->audiences[0].wire);
  // A reader that shares a socket with a usual route gets the sample by that route, and has no fallback lane.
  ASSERT_EQ(t->audiences[1].lanes.size(), 1U);
  EXPECT_NE(t->audiences[1].lanes[0], t->audiences[0].lanes[0]);
  const auto after = table({route(2, data)});
  EXPECT_EQ(after->audiences[0].lanes[0], t->audiences[1].lanes[0]);
}

TEST_F(RoutesTest, GroupsReadersByMaximumRateToo) {
  const auto slow = std::make_shared<const core::Gate>(100'000);
  core::Route limited = route(1, fields<Image>("data"));
  limited.gate = slow;
  core::Route other = route(2, fields<Image>("data"));
  other.gate = slow;
  const auto t = table({route(1, fields<Image>("data")), limited, other});
  ASSERT_EQ(t->audiences.size(), 2U);
  EXPECT_EQ(t->audiences[0].gate, nullptr);
  EXPECT_EQ(t->audiences[1].gate, slow);
  EXPECT_EQ(t->audiences[1].lanes.size(), 2U);
  EXPECT_NE(t->audiences[0].wire->variant, t->audiences[1].wire->variant);
}

TEST_F(RoutesTest, ServesALateReaderApartByOneLaneWhateverItAsksFor) {
  core::Route late = route(1, fields<Image>("data"));
  late.history = 3;
  const core::Route other{2, late.destination, late.selection};
  const auto before = table({late, other});
  ASSERT_EQ(before->audiences.size(), 2U);
  EXPECT_EQ(before->of_late_reader(1), before->audiences.data());
  EXPECT_FALSE(variants_.late_lane_idle(1)) << "its history is not known yet";
  late.selection = fields<Image>("name");
  const auto after = table({late, other});
  EXPECT_EQ(after->audiences[0].lanes, before->audiences[0].lanes);
  EXPECT_NE(after->audiences[0].wire->variant, before->audiences[0].wire->variant);
  late.history = 0;
  EXPECT_EQ(table({late, other})->of_late_reader(1), nullptr);
  EXPECT_TRUE(variants_.late_lane_idle(1));
}

TEST_F(RoutesTest, ALateReaderThatMovesBeginsAnew) {
  core::Route late = route(1, fields<Image>("data"));
  late.history = 3;
  const auto before = table({late});
  EXPECT_EQ(before->audiences[0].lanes[0]->begin({}), Wake::none);
  EXPECT_TRUE(variants_.late_lane_idle(1));
  std::get<core::UdpAddress>(late.destination).port = 2;
  table({late});
  EXPECT_TRUE(before->audiences[0].lanes[0]->closed());
  EXPECT_FALSE(variants_.late_lane_idle(1));
}

TEST_F(RoutesTest, LeavesReadersInSharedMemoryOut) {
  EXPECT_TRUE(
      table({{1, core::DoorbellAddress{.page = 1, .slot = 2}, fields<Image>("*")}})->audiences.empty());
}

TEST_F(RoutesTest, KeepsNumberAndLanesOfAMaskThroughChanges) {
  const auto before = table({route(1, fields<Image>("data"))});
  table({route(1, fields<Image>("name"))});
  const auto after = table({route(2, fields<Image>("name")), route(1, fields<Image>("data"))});
  EXPECT_FALSE(before->audiences[0].lanes[0]->closed());
  EXPECT_EQ(before->audiences[0].wire->variant, after->audiences[1].wire->variant);
  EXPECT_EQ(before->audiences[0].lanes, after->audiences[1].lanes);
}

TEST_F(RoutesTest, SharesADestinationAmongMasks) {
  const auto t = table({route(1, fields<Image>("data")), route(1, fields<Image>("name"))});
  EXPECT_EQ(&t->audiences[0].lanes[0]->destination(), &t->audiences[1].lanes[0]->destination());
  EXPECT_NE(t->audiences[0].lanes[0], t->audiences[1].lanes[0]);
}

TEST_F(RoutesTest, ClosesTheLanesToADestinationThatNoRouteLeadsTo) {
  const auto data = table({route(1, fields<Image>("data")), route(2, fields<Image>("data"))});
  table({route(1, fields<Image>("name")), route(2, fields<Image>("data"))});
  table({route(2, fields<Image>("data"))});
  EXPECT_TRUE(data->audiences[0].lanes[0]->closed()) << "also that of the mask before";
  EXPECT_FALSE(data->audiences[0].lanes[1]->closed());
  const auto back = table({route(1, fields<Image>("data"))});
  EXPECT_FALSE(back->audiences[0].lanes[0]->closed());
}

TEST_F(RoutesTest, TellsOnceThatLanesWereClosedButNothingOfAReaderThatAsksForSomethingElse) {
  table({route(1, fields<Image>("data")), route(2, fields<Image>("data"))});
  table({route(1, fields<Image>("name")), route(2, fields<Image>("data"))});
  EXPECT_FALSE(variants_.concern_sender());
  table({route(2, fields<Image>("data"))});
  EXPECT_TRUE(variants_.concern_sender());
  EXPECT_FALSE(variants_.concern_sender());
}

TEST_F(RoutesTest, TellsOnceThatADestinationHasMoved) {
  core::UdpAddress address{0x7f000001, 1, 1'000'000};
  address.node = 9;
  core::Route there = route(1, fields<Image>("data"));
  there.destination = address;
  table({there});
  EXPECT_FALSE(variants_.concern_sender());
  address.ip = 0x7f000002;
  there.destination = address;
  table({there});
  EXPECT_TRUE(variants_.concern_sender());
  table({there});
  EXPECT_FALSE(variants_.concern_sender());
}

TEST_F(RoutesTest, TellsThatTheLaneOfALateReaderThatMovesWasClosed) {
  core::Route late = route(1, fields<Image>("data"));
  late.reader = 7;
  late.history = 3;
  table({late});
  EXPECT_FALSE(variants_.concern_sender());
  late.destination = core::UdpAddress{0x7f000001, 2, 1'000'000};
  table({late, route(1, fields<Image>("data"))});
  EXPECT_TRUE(variants_.concern_sender());
}

TEST_F(RoutesTest, ConnectsToAnAddressOnceAndOnlyWhileARouteLeadsThere) {
  auto t = table(
      {route(1, fields<Image>("data")), route(1, fields<Image>("name")), route(2, fields<Image>("data"))});
  EXPECT_EQ(connections_.open(), 2U);
  t = table({route(2, fields<Image>("name"))});
  EXPECT_EQ(connections_.open(), 1U);
  t = table({});
  EXPECT_EQ(connections_.open(), 0U);
}

TEST_F(RoutesTest, SendsTheWordsOfMasksThatTheHeaderCannotHold) {
  const auto narrow = table({route(1, fields<Image>("data"))});
  EXPECT_TRUE(narrow->audiences[0].wire->words.empty());
  const auto wide = table<Wide>({route(1, fields<Wide>("first"))});
  EXPECT_EQ(wide->audiences[0].wire->words.size(), 2U);
  EXPECT_EQ(wide->audiences[0].wire->mask, fields<Wide>("first").hash());
}

TEST_F(RoutesTest, ReusesANumberOnlyAfterAllOthers) {
  std::vector<std::uint16_t> numbers;
  for (std::uint64_t i = 0; i < 70'000; ++i) {
    variants_.next_round();
    numbers.push_back(variants_.find({mask(i)}).wire->variant);
  }
  EXPECT_EQ(std::set<std::uint16_t>(numbers.begin(), numbers.begin() + 65'536).size(), 65'536U);
}

TEST_F(RoutesTest, NeverGivesANumberThatIsInUse) {
  const std::uint16_t kept = variants_.find({mask(1'000'000)}).wire->variant;
  for (std::uint64_t i = 0; i < 70'000; ++i) {
    variants_.next_round();
    EXPECT_EQ(variants_.find({mask(1'000'000)}).wire->variant, kept);
    EXPECT_NE(variants_.find({mask(i)}).wire->variant, kept);
  }
}

TEST_F(RoutesTest, GivesManyMasksAtOnceANumberEach) {
  std::vector<core::Route> routes;
  for (std::uint64_t i = 0; i < 500; ++i) routes.push_back(route(1, mask(i)));
  for (int round = 0; round < 3; ++round) {
    std::set<std::uint16_t> numbers;
    const auto t = table(routes);
    for (const Audience& audience : t->audiences) numbers.insert(audience.wire->variant);
    EXPECT_EQ(numbers.size(), 500U);
  }
}

}  // namespace
}  // namespace sft::udp
