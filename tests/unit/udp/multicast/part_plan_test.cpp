// These tests check the plans for destinations that request parts of fields.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/support/test_seed.h"
#include "udp_transport/multicast/multicast_plan.h"
#include "udp_transport/multicast/one_copy.h"

namespace sft::udp {
namespace {

constexpr double very_often = 1e6;
constexpr std::size_t datagram_room = 1472;
constexpr std::size_t leaves_in_all = 8;

FieldMask leaf(std::uint64_t number) {
  return FieldMask::from_words(leaves_in_all, std::array{std::uint64_t{1} << number});
}
/// Returns a selection of every `step`th element of each field in the mask.
Selection each(std::uint32_t step, const FieldMask& mask) {
  std::vector<Selection::Part> parts;
  for (const std::size_t number : mask)
    parts.push_back({.leaf = static_cast<std::uint32_t>(number), .columns = {.step = step}});
  return Selection::make(mask, std::move(parts), {}).value();
}
const Selection whole_cloud = leaf(0);
const Selection scalars = leaf(1) | leaf(2);

/// Returns a function that computes the size of a body as the sum of its fields. A part with step n has the
/// size of its field divided by n.
BodyBytes sized(std::vector<double> bytes) {
  return [bytes](const Selection& sent) {
    double all = 0;
    for (const std::size_t number : sent.mask()) {
      const Selection::Part* const part = sent.part(number);
      all += bytes[number] / (part == nullptr ? 1 : part->columns.step);
    }
    return all;
  };
}

PlanDestination asks_for(const std::vector<Selection>& asked, const BodyBytes& bytes) {
  PlanDestination to{.datagram_bytes = datagram_room};
  for (std::size_t i = 0; i < asked.size(); ++i) {
    add_to_copy(to.fields, asked[i], i == 0);
    to.alone_bytes += wire_bytes(bytes(asked[i]), datagram_room, PlaceMark::none);
  }
  return to;
}
MulticastPlan plan_for(const std::vector<Selection>& asked, const BodyBytes& bytes) {
  std::vector<PlanDestination> all;
  for (const Selection& one : asked) all.push_back(asks_for({one}, bytes));
  return plan_multicast(all, bytes, very_often, {}, {});
}

TEST(OneCopy, HasAPartOnlyWhereAllAskForJustThat) {
  const Selection third = each(3, leaf(0)), fourth = each(4, leaf(0));
  EXPECT_EQ(one_copy(third, third), third);
  EXPECT_EQ(one_copy(third, fourth), whole_cloud);
  EXPECT_EQ(one_copy(third, whole_cloud), whole_cloud);
  EXPECT_EQ(one_copy(third, scalars), Selection(leaf(0) | leaf(1) | leaf(2)));
}

TEST(OneCopy, DoesNotDependOnTheOrderOfThoseItServes) {
  const std::vector<Selection> some{each(3, leaf(0)), each(3, leaf(0)), each(4, leaf(0) | leaf(1)),
                                    whole_cloud,      scalars,          leaf(0) | leaf(1)};
  for (const Selection& a : some) {
    EXPECT_EQ(one_copy(a, a), a);
    for (const Selection& b : some) {
      EXPECT_EQ(one_copy(a, b), one_copy(b, a));
      EXPECT_EQ(one_copy(one_copy(a, b), a), one_copy(a, b));
      for (const Selection& c : some) EXPECT_EQ(one_copy(one_copy(a, b), c), one_copy(a, one_copy(b, c)));
    }
  }
}

struct PartCase {
  const char* what;
  std::vector<Selection> asked;  ///< the selection of each destination
  std::vector<double> bytes;     ///< the size of each whole field, in bytes
  MulticastPlan best;
};

TEST(PartPlan, IsTheCheapestOfEachCase) {
  const Selection third = each(3, leaf(0)), fourth = each(4, leaf(0));
  const Selection most_of_it = each(1, leaf(0));
  ASSERT_EQ(most_of_it, whole_cloud) << "all elements are the whole field";
  const std::vector<PartCase> cases{
      {"the same part: one group with that part",
       {third, third, third, third},
       {1e6},
       {{third, {0, 1, 2, 3}}}},
      {"two parts: two groups", {third, fourth, third, fourth}, {1e6}, {{third, {0, 2}}, {fourth, {1, 3}}}},
      {"two small parts of a small field: one group with the whole field",
       {third, fourth},
       {60},
       {{whole_cloud, {0, 1}}}},
      {"many different parts: the whole field once is less than each part alone",
       {each(2, leaf(0)), each(3, leaf(0)), each(4, leaf(0)), each(5, leaf(0)), each(6, leaf(0))},
       {1e6},
       {{whole_cloud, {0, 1, 2, 3, 4}}}},
      {"a part beside the whole: the group of the whole does without it",
       {whole_cloud, whole_cloud, each(100, leaf(0))},
       {1e6},
       {{whole_cloud, {0, 1}}}},
      {"a part that is nearly everything goes by the group of the whole",
       {leaf(0), leaf(0), each(2, leaf(0))},
       {1e6},
       {{whole_cloud, {0, 1, 2}}}},
      {"scalars stay out of a group with a part", {third, third, scalars}, {1e6, 4, 4}, {{third, {0, 1}}}},
  };
  for (const PartCase& c : cases) EXPECT_EQ(plan_for(c.asked, sized(c.bytes)), c.best) << c.what;
}

TEST(PartPlan, ServesAProcessWithSeveralPartsByWhatServesAllOfThem) {
  const BodyBytes bytes = sized({1e6});
  const Selection half = each(2, leaf(0)), third = each(3, leaf(0));
  std::vector<PlanDestination> all;
  for (int i = 0; i < 4; ++i) all.push_back(asks_for({half, third}, bytes));
  EXPECT_EQ(plan_multicast(all, bytes, very_often, {}, {}), (MulticastPlan{{whole_cloud, {0, 1, 2, 3}}}));
}

/// Destinations that ask for random fields and parts.
struct PartTask {
  PartTask(sft::test::Random& random, std::size_t kinds) {
    const std::size_t leaves = 1 + random() % 5;
    std::vector<double> sizes(leaves_in_all);
    for (double& size : sizes) size = static_cast<double>(8U << random() % 14);
    bytes = sized(sizes);
    for (std::size_t kind = 0; kind < kinds; ++kind) {
      FieldMask fields(leaves_in_all);
      for (std::size_t number = 0; number < leaves; ++number) {
        if (random() % 2 == 0) fields.insert(number);
      }
      if (fields.empty()) fields.insert(0);
      const Selection asked =
          random() % 3 == 0 ? Selection(fields) : each(static_cast<std::uint32_t>(1 + random() % 4), fields);
      if (std::ranges::find(all, asked, &PlanDestination::fields) != all.end()) continue;
      const std::size_t count = 1 + random() % 3;
      for (std::size_t i = 0; i < count; ++i) all.push_back(asks_for({asked}, bytes));
    }
  }

  PlanCost cost_of(const MulticastPlan& plan) const {
    PlanCost sum;
    for (const PlanDestination& to : all) sum = sum + PlanCost{to.alone_bytes, to.alone_bytes};
    for (const PlannedGroup& group : plan) {
      Selection sent = all[group.members[0]].fields;
      for (const std::size_t member : group.members) sent = one_copy(sent, all[member].fields);
      EXPECT_EQ(sent, group.fields) << "it is told what serves all members, and nothing else";
      const double together = wire_bytes(bytes(sent), datagram_room, PlaceMark::in_group);
      sum = sum + PlanCost{together, together};
      for (const std::size_t member : group.members) {
        const double alone = all[member].alone_bytes;
        sum.cost += PlanLimits{}.unwanted_weight * std::max(0.0, together - alone);
        sum = sum - PlanCost{alone, alone};
      }
    }
    return sum;
  }
  double wire_max() const {
    PlannedGroup everybody;
    for (std::size_t i = 0; i < all.size(); ++i) {
      add_to_copy(everybody.fields, all[i].fields, i == 0);
      everybody.members.push_back(i);
    }
    const double together = all.size() < 2 ? cost_of({}).wire : cost_of({everybody}).wire;
    return PlanLimits{}.wire_max * std::min(together, cost_of({}).wire);
  }
  std::vector<PlanDestination> all;
  BodyBytes bytes;
};

class PartPlanTest : public sft::test::RandomTest {};

TEST_F(PartPlanTest, PutsNoMoreOnTheWireThanItMayWhateverIsAskedFor) {
  for (int i = 0; i < 300; ++i) {
    const PartTask task(random, 1 + random() % 6);
    const PlanCost cost = task.cost_of(plan_multicast(task.all, task.bytes, very_often, {}, {}));
    ASSERT_LE(cost.wire, task.wire_max() * (1 + 1e-9)) << "case " << i;
  }
}

TEST_F(PartPlanTest, PutsNoMoreOnTheWireThanOneGroupOfAllOrNoneHoweverManyPartsThereAre) {
  for (const std::size_t kinds : {9U, 16U, 64U}) {
    const PartTask task(random, kinds);
    const PlanCost cost = task.cost_of(plan_multicast(task.all, task.bytes, very_often, {}, {}));
    EXPECT_LE(cost.wire, task.wire_max() * (1 + 1e-9)) << kinds << " kinds";
  }
}

}  // namespace
}  // namespace sft::udp
