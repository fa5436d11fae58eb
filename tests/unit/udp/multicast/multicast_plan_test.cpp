#include "udp_transport/multicast/multicast_plan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "tests/support/test_seed.h"
#include "udp_transport/multicast/one_copy.h"

namespace sft::udp {
namespace {

constexpr double often = 1e6;  // samples per second; so many that every saving of bytes is worth a group
constexpr std::size_t datagram_bytes = 1472;

FieldMask some(std::uint64_t bits) { return FieldMask::from_words(64, std::array{bits}); }
const FieldMask A = some(1), B = some(2);
/// The masks that the readers in one process ask for.
using Masks = std::vector<FieldMask>;

/// Returns a function that computes the size of a body as the sum of its fields; `bytes` has the size of
/// each field.
BodyBytes apart(std::vector<double> bytes) {
  return [bytes](const Selection& sent) {
    double all = 0;
    for (const std::size_t leaf : sent.mask()) all += leaf < bytes.size() ? bytes[leaf] : 0;
    return all;
  };
}

PlanDestination destination(const Masks& masks, const BodyBytes& bytes,
                            std::size_t datagrams = datagram_bytes) {
  PlanDestination to{.fields = FieldMask(64), .datagram_bytes = datagrams};
  for (const FieldMask& mask : masks) {
    to.fields = one_copy(to.fields, mask);
    to.alone_bytes += wire_bytes(bytes(mask), datagrams, PlaceMark::none);
  }
  return to;
}
std::vector<PlanDestination> destinations(const std::vector<FieldMask>& masks, const BodyBytes& bytes) {
  std::vector<PlanDestination> all;
  for (const FieldMask& mask : masks) all.push_back(destination({mask}, bytes));
  return all;
}

/// Returns the cost of a plan as multicast.md defines it. The gain of a change of plans is the difference of
/// two costs.
PlanCost plan_cost(const std::vector<PlanDestination>& destinations, const BodyBytes& body_bytes,
                   const MulticastPlan& plan) {
  PlanCost all;
  for (const PlanDestination& to : destinations) all = all + PlanCost{to.alone_bytes, to.alone_bytes};
  for (const PlannedGroup& group : plan) {
    std::size_t shortest = SIZE_MAX;
    for (const std::size_t member : group.members)
      shortest = std::min(shortest, destinations[member].datagram_bytes);
    const double together = wire_bytes(body_bytes(group.fields), shortest, PlaceMark::in_group);
    all = all + PlanCost{together, together};
    for (const std::size_t member : group.members) {
      const double alone = destinations[member].alone_bytes;
      all.cost += PlanLimits{}.unwanted_weight * std::max(0.0, together - alone);
      all = all - PlanCost{alone, alone};
    }
  }
  return all;
}

/// Returns the maximum number of bytes that a plan may put on the link. It is the bytes of one group of all
/// destinations, or the bytes without groups if that is less, times PlanLimits::wire_max.
double wire_bytes_max(const std::vector<PlanDestination>& destinations, const BodyBytes& body_bytes) {
  PlannedGroup all{FieldMask(64), {}};
  for (std::size_t i = 0; i < destinations.size(); ++i) {
    add_to_copy(all.fields, destinations[i].fields, all.members.empty());
    all.members.push_back(i);
  }
  const double together = plan_cost(destinations, body_bytes, {all}).wire;
  return PlanLimits{}.wire_max * std::min(together, plan_cost(destinations, body_bytes, {}).wire);
}

MulticastPlan plan(const std::vector<FieldMask>& masks, const BodyBytes& bytes,
                   const MulticastPlan& present = {}) {
  return plan_multicast(destinations(masks, bytes), bytes, often, present, {});
}

TEST(WireBytes, CountAllHeadersOfAllDatagrams) {
  EXPECT_EQ(wire_bytes(100, 1472, PlaceMark::none), 100 + 28 + 42);
  EXPECT_EQ(wire_bytes(1444, 1472, PlaceMark::none), 1444 + 28 + 42) << "just fits";
  EXPECT_EQ(wire_bytes(1445, 1472, PlaceMark::none), 1445 + 32 + 13 + 2 * 42);
  EXPECT_EQ(wire_bytes(0, 1472, PlaceMark::none), 28 + 42);
}

TEST(WireBytes, CountThePlaceOfASampleThatOneDatagramInAChannelDoesNotCarry) {
  EXPECT_EQ(wire_bytes(1440, 1472, PlaceMark::in_channel), 1440 + 32 + 42);
  EXPECT_EQ(wire_bytes(1441, 1472, PlaceMark::in_channel), 1441 + 48 + 13 + 2 * 42);
  EXPECT_EQ(wire_bytes(100, 1472, PlaceMark::in_group), 100 + 48 + 42);
}

TEST(MulticastPlan, CostsWhatIsDocumented) {
  const auto cost = [](const std::vector<FieldMask>& masks, std::vector<double> sizes,
                       const MulticastPlan& plan) {
    const BodyBytes bytes = apart(std::move(sizes));
    return std::lround(plan_cost(destinations(masks, bytes), bytes, plan).cost);
  };
  const std::vector<FieldMask> eight(8, A), halves{A, A, A, A, B, B, B, B};
  EXPECT_EQ(cost(eight, {1000}, {}), 8560);
  EXPECT_EQ(cost(eight, {1000}, {{A, {0, 1, 2, 3, 4, 5, 6, 7}}}), 1130);
  EXPECT_EQ(cost(halves, {10'000, 10'000}, {}), 83'232);
  EXPECT_EQ(cost(halves, {10'000, 10'000}, {{A, {0, 1, 2, 3}}, {B, {4, 5, 6, 7}}}), 20'872);
  EXPECT_EQ(cost({A, B}, {8, 8}, {{A | B, {0, 1}}}), 120);
  EXPECT_EQ(cost({A, A, B}, {10'000, 8}, {{A, {0, 1}}}), 10'506);
}

struct Case {
  const char* what;
  std::vector<Masks> masks;   ///< the masks of each destination
  std::vector<double> bytes;  ///< the size of each field, in bytes
  MulticastPlan best;
};

TEST(MulticastPlan, IsTheCheapestOfEachCase) {
  const std::vector<Case> cases{
      {"nobody", {}, {100}, {}},
      {"one reader", {{A}}, {1000}, {}},
      {"one process with two masks", {{A, B}}, {1000, 1000}, {}},
      {"two that ask for the same", {{A}, {A}}, {1000}, {{A, {0, 1}}}},
      {"eight, two masks: two groups",
       {{A}, {B}, {A}, {B}, {A}, {B}, {A}, {B}},
       {10'000, 10'000},
       {{A, {0, 2, 4, 6}}, {B, {1, 3, 5, 7}}}},
      {"two small masks: their headers cost more than the other fields",
       {{A}, {B}},
       {8, 8},
       {{A | B, {0, 1}}}},
      {"two large ones that have nothing in common", {{A}, {B}}, {10'000, 10'000}, {}},
      {"a large one and one that asks for a few of its bytes", {{A}, {A}, {B}}, {10'000, 8}, {{A, {0, 1}}}},
      {"one process asks for what two others ask for",
       {{A}, {B}, {A, B}},
       {1000, 1000},
       {{A | B, {0, 1, 2}}}},
  };
  for (const Case& c : cases) {
    const BodyBytes bytes = apart(c.bytes);
    std::vector<PlanDestination> all;
    for (const Masks& masks : c.masks) all.push_back(destination(masks, bytes));
    EXPECT_EQ(plan_multicast(all, bytes, often, {}, {}), c.best) << c.what;
  }
}

TEST(MulticastPlan, HasGroupsBehindOneLinkOnly) {
  std::vector<PlanDestination> all = destinations({A, A, A, A}, apart({1000}));
  all[1].division = all[3].division = 1;
  const MulticastPlan best{{A, {0, 2}}, {A, {1, 3}}};
  EXPECT_EQ(plan_multicast(all, apart({1000}), often, {}, {}), best);
  all[2].division = 2;
  EXPECT_EQ(plan_multicast(all, apart({1000}), often, {}, {}), (MulticastPlan{{A, {1, 3}}}));
}

TEST(MulticastPlan, TakesInWhoJoinsAndGoesOnWithoutWhoLeaves) {
  const BodyBytes bytes = apart({1000});
  const MulticastPlan two = plan({A, A}, bytes);
  const MulticastPlan three{{A, {0, 1, 2}}};
  EXPECT_EQ(plan({A, A, A}, bytes, two), three);
  EXPECT_EQ(plan({A, A}, bytes, {{A, {0, 1}}}), two);
}

TEST(MulticastPlan, FollowsAMaskThatChanges) {
  const BodyBytes bytes = apart({10'000, 10'000});
  EXPECT_EQ(plan({A, A, A}, bytes), (MulticastPlan{{A, {0, 1, 2}}}));
  EXPECT_EQ(plan({A, A, B}, bytes, {{A | B, {0, 1, 2}}}), (MulticastPlan{{A, {0, 1}}}))
      << "it is sent too much";
}

TEST(MulticastPlan, StaysAsItIsForASmallGain) {
  // In the first case below, a change would save 16 * 100 bytes, which is too small relative to the cost.
  const std::vector<FieldMask> masks{A, A, A, A, B, B};
  const MulticastPlan present{{A, {0, 1, 2, 3}}};
  EXPECT_EQ(plan(masks, apart({100'000, 100}), present), present);
  EXPECT_EQ(plan(masks, apart({100'000, 100'000}), present), (MulticastPlan{{A, {0, 1, 2, 3}}, {B, {4, 5}}}));
}

TEST(MulticastPlan, DoesNotFlapWhileSizesVary) {
  std::mt19937 random(1);
  MulticastPlan present;
  int changes = 0;
  // The sizes are close to the size at which one group for both destinations becomes cheaper.
  for (int i = 0; i < 1000; ++i) {
    const double b = 28 + static_cast<double>(random() % 9);
    MulticastPlan next = plan({A, B}, apart({30, b}), present);
    changes += next == present ? 0 : 1;
    present = std::move(next);
  }
  EXPECT_LE(changes, 1);
}

TEST(MulticastPlan, IsKeptWhileItCostsAtMostATwentiethMoreThanTheBest) {
  const FieldMask C = some(4);
  const MulticastPlan present{{A | C, {0, 1, 4}}, {B | C, {2, 3}}};
  PlanLimits usual, eager;
  usual.wire_max = eager.wire_max = 2;
  eager.gain_min = 0;
  double dearest_kept = 1, cheapest_left = 2;  // costs of the present plan, divided by that of the best plan
  // The last destination asks for C only, but its group also sends A. So the present plan costs more as `a`
  // grows.
  for (double a = 1000; a < 5000; a += 2) {
    const BodyBytes bytes = apart({a, 1000, 500});
    const std::vector<PlanDestination> all = destinations({A | C, A | C, B | C, B | C, C}, bytes);
    const double least = plan_cost(all, bytes, plan_multicast(all, bytes, often, present, eager)).cost;
    const double cost = plan_cost(all, bytes, present).cost / least;
    if (plan_multicast(all, bytes, often, present, usual) == present)
      dearest_kept = std::max(dearest_kept, cost);
    else
      cheapest_left = std::min(cheapest_left, cost);
  }
  EXPECT_LE(dearest_kept, 1 + PlanLimits{}.gain_min);
  EXPECT_GT(cheapest_left, 1 + PlanLimits{}.gain_min);
  EXPECT_NEAR(dearest_kept, cheapest_left, 1e-3) << "both are seen";
}

TEST(MulticastPlan, HasNoGroupForATopicThatIsSeldomSent) {
  const std::vector<PlanDestination> all = destinations({A, A, A, A, A, A, A, A}, apart({100}));
  EXPECT_TRUE(plan_multicast(all, apart({100}), 1, {}, {}).empty());
  EXPECT_FALSE(plan_multicast(all, apart({100}), 100, {}, {}).empty());
}

TEST(MulticastPlan, LeavesAGroupOfAllForTheBytesThatMembersGetAndHaveNotAskedFor) {
  // One group of all destinations saves 20 % of the bytes of two groups, but two members get fields that
  // they did not request.
  PlanLimits indifferent;
  indifferent.unwanted_weight = 0;
  indifferent.wire_max = 2;
  PlanLimits usual;
  usual.wire_max = 2;
  const BodyBytes nearly_equal = [](const Selection& fields) {
    return fields == (A | B) ? 1200.0 : fields == A ? 1100.0 : 300.0;
  };
  const std::vector<PlanDestination> all = destinations({A, A, B, B}, nearly_equal);
  const MulticastPlan present{{A | B, {0, 1, 2, 3}}};
  EXPECT_EQ(plan_multicast(all, nearly_equal, often, present, indifferent), present);
  EXPECT_EQ(plan_multicast(all, nearly_equal, often, present, usual).size(), 2U);
}

TEST(MulticastPlan, HasNoGroupForOneCopyThatIsMoreThanAllThatItsReadersAskFor) {
  // Each of two processes has two readers, which read small parts of one field. A copy for both processes has
  // the whole field.
  std::vector<PlanDestination> all = destinations({A, A}, apart({10'000}));
  for (PlanDestination& to : all) to.alone_bytes = 2 * wire_bytes(500, datagram_bytes, PlaceMark::none);
  EXPECT_TRUE(plan_multicast(all, apart({10'000}), often, {}, {}).empty());
}

TEST(MulticastPlan, LeavesThoseWhoAskForLittleOutOfTheGroupOfAll) {
  const FieldMask C = some(4), D = some(8);
  const BodyBytes bytes = apart({10'000, 100, 100, 8});
  EXPECT_EQ(plan({A | B, A | C, A, D}, bytes), (MulticastPlan{{A | B | C, {0, 1, 2}}}));
  EXPECT_EQ(plan({A | B, D, A | C, A, D}, bytes), (MulticastPlan{{A | B | C, {0, 2, 3}}, {D, {1, 4}}}));
}

TEST(MulticastPlan, LeavesThoseOutOfTheGroupOfAllWhoHaveLittleInCommonWithIt) {
  const FieldMask C = some(4), D = some(8);
  EXPECT_EQ(plan({A | B, A | C, A, D}, apart({10'000, 100, 100, 5'000})),
            (MulticastPlan{{A | B | C, {0, 1, 2}}}));
}

TEST(MulticastPlan, HasGroupsWhereTheySaveMostIfThereAreTooMany) {
  const std::size_t most = PlanLimits{}.groups_max;
  std::vector<double> sizes(most + 1, 100'000);
  sizes[3] = 100;
  std::vector<FieldMask> masks;
  for (std::size_t i = 0; i < 2 * sizes.size(); ++i) masks.push_back(some(std::uint64_t{1} << i / 2));
  const MulticastPlan best = plan(masks, apart(sizes));
  EXPECT_EQ(best.size(), most);
  for (const PlannedGroup& group : best) EXPECT_NE(group.fields, masks[6]);
}

TEST(MulticastPlan, PutsANewcomerToThoseWhoAskForTheSameAndLeavesTheOthersWhereTheyAre) {
  const BodyBytes bytes = apart({10'000, 10'000});
  const MulticastPlan present{{A, {0, 1}}, {B, {2, 3}}};
  EXPECT_EQ(plan({A, A, B, B, B}, bytes, present), (MulticastPlan{{A, {0, 1}}, {B, {2, 3, 4}}}));
}

/// Destinations that ask for random fields of random sizes.
struct RandomTask {
  RandomTask(sft::test::Random& random, std::size_t kinds) {
    const std::size_t leaves = 1 + random() % 10;
    const auto style = random() % 3;
    std::vector<double> sizes;
    for (std::size_t i = 0; i < leaves; ++i) {
      sizes.push_back(static_cast<double>(style == 0   ? 8U << random() % 12
                                          : style == 1 ? 4 + random() % 64
                                                       : random() % 20'000));
    }
    bytes = apart(sizes);
    for (std::size_t kind = 0; kind < kinds; ++kind) {
      const auto density = 1 + random() % 4;
      FieldMask fields(64);
      for (std::size_t leaf = 0; leaf < leaves; ++leaf) {
        if (random() % 4 < density) fields.insert(leaf);
      }
      const std::size_t count = 1 + (random() % 3 == 0 ? random() % 4 : 0);
      for (std::size_t i = 0; i < count; ++i) all.push_back(destination({fields}, bytes));
    }
  }

  double wire_max() const { return wire_bytes_max(all, bytes); }
  std::vector<PlanDestination> all;
  BodyBytes bytes;
};

class MulticastPlanTest : public sft::test::RandomTest {};

TEST_F(MulticastPlanTest, PutsNoMoreOnTheWireThanItMayWhateverIsAskedFor) {
  for (int i = 0; i < 1000; ++i) {
    const RandomTask task(random, 1 + random() % 8);
    const PlanCost cost =
        plan_cost(task.all, task.bytes, plan_multicast(task.all, task.bytes, often, {}, {}));
    ASSERT_LE(cost.wire, task.wire_max() * (1 + 1e-9)) << "case " << i;
  }
}

TEST_F(MulticastPlanTest, PutsNoMoreOnTheWireThanOneGroupOfAllOrNoneHoweverManyMasksThereAre) {
  for (const std::size_t masks : {9U, 16U, 64U, 200U}) {
    RandomTask task(random, masks);
    const MulticastPlan best = plan_multicast(task.all, task.bytes, often, {}, {});
    const PlanCost cost = plan_cost(task.all, task.bytes, best);
    const FieldMask whole = FieldMask::full(64);
    const double everything = wire_bytes(task.bytes(whole), datagram_bytes, PlaceMark::in_group);
    const double all_alone = plan_cost(task.all, task.bytes, {}).wire;
    EXPECT_LE(cost.wire, 1.05 * std::min(everything, all_alone) * (1 + 1e-9)) << masks << " masks";
  }
}

TEST_F(MulticastPlanTest, WeighsAboutAsManyUnionsAsThereAreMasks) {
  for (const std::size_t masks : {16U, 64U, 200U}) {
    std::vector<double> sizes;
    for (int i = 0; i < 64; ++i) sizes.push_back(4 + static_cast<double>(random() % 1000));
    const BodyBytes bytes = apart(sizes);
    std::vector<PlanDestination> all;
    for (std::size_t i = 0; i < masks; ++i) all.push_back(destination({some(random())}, bytes));
    std::size_t weighed = 0;
    const BodyBytes counted = [&](const Selection& fields) { return ++weighed, bytes(fields); };
    const MulticastPlan best = plan_multicast(all, counted, often, {}, {});
    EXPECT_LE(weighed, 2 * masks + 2);
    ASSERT_FALSE(best.empty());

    all.push_back(destination({some(random())}, bytes));
    EXPECT_LE(plan_cost(all, bytes, plan_multicast(all, bytes, often, best, {})).wire,
              wire_bytes_max(all, bytes) * (1 + 1e-9));
  }
}

TEST(PlacesOfGroups, AreKeptByGroupsThatStayAndAreNeverShared) {
  using Places = std::vector<std::size_t>;
  const auto groups = [](std::vector<std::vector<std::size_t>> members) {
    MulticastPlan plan;
    for (auto& one : members) plan.push_back({{}, std::move(one)});
    return plan;
  };
  const MulticastPlan none;
  EXPECT_EQ(keep_places(none, {}, groups({{0, 1}, {2, 3}})), (Places{0, 1}));
  const MulticastPlan present = groups({{2, 3}, {4, 5}});
  EXPECT_EQ(keep_places(present, Places{0, 1}, groups({{0, 4, 5}, {2, 3}})), (Places{1, 0}));
  EXPECT_EQ(keep_places(present, Places{0, 1}, groups({{0, 1}, {4, 5}})), (Places{0, 1}));
  EXPECT_EQ(keep_places(present, Places{0, 1}, groups({{0, 3}, {1, 2}, {4, 5}})), (Places{0, 2, 1}));
  EXPECT_EQ(keep_places(present, Places{3, 7}, groups({{2, 3, 4, 5}, {0, 1}})), (Places{3, 0}));
}

}  // namespace
}  // namespace sft::udp
