#include "udp_transport/multicast/multicast_plan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <vector>

#include "tests/support/test_seed.h"

namespace sft::udp {
namespace {

constexpr MaskSet A = 1, B = 2;
constexpr double often = 1e6;  // samples per second: whatever is saved is worth it

/// Bodies whose masks have nothing in common.
BodyBytes apart(std::vector<double> bytes) {
  return [bytes](MaskSet set) {
    double all = 0;
    for (std::size_t i = 0; i < bytes.size(); ++i) all += (set >> i & 1) != 0 ? bytes[i] : 0;
    return all;
  };
}

std::vector<PlanDestination> destinations(const std::vector<MaskSet>& masks) {
  std::vector<PlanDestination> all;
  for (const MaskSet set : masks) all.push_back({.masks = set, .datagram_bytes = 1472});
  return all;
}

MulticastPlan plan(const std::vector<MaskSet>& masks, const BodyBytes& bytes,
                   const MulticastPlan& present = {}) {
  return plan_multicast(destinations(masks), bytes, often, present, {});
}

TEST(WireBytes, CountAllHeadersOfAllDatagrams) {
  EXPECT_EQ(wire_bytes(100, 1472, PlaceMark::none), 100 + 32 + 42);
  EXPECT_EQ(wire_bytes(1440, 1472, PlaceMark::none), 1440 + 32 + 42) << "just fits";
  EXPECT_EQ(wire_bytes(1441, 1472, PlaceMark::none), 1441 + 32 + 16 + 2 * 42);
  EXPECT_EQ(wire_bytes(0, 1472, PlaceMark::none), 32 + 42);
}

TEST(WireBytes, CountThePlaceOfASampleThatOneDatagramInAChannelDoesNotCarry) {
  EXPECT_EQ(wire_bytes(1440, 1472, PlaceMark::in_channel), 1440 + 32 + 42);
  EXPECT_EQ(wire_bytes(1441, 1472, PlaceMark::in_channel), 1441 + 48 + 16 + 2 * 42);
  EXPECT_EQ(wire_bytes(100, 1472, PlaceMark::in_group), 100 + 48 + 42);
}

TEST(MulticastPlan, CostsWhatIsDocumented) {
  const auto cost = [](const std::vector<MaskSet>& masks, std::vector<double> bytes,
                       const MulticastPlan& plan) {
    return std::lround(plan_cost(destinations(masks), apart(std::move(bytes)), plan, {}));
  };
  const std::vector<MaskSet> eight(8, A), halves{A, A, A, A, B, B, B, B};
  EXPECT_EQ(cost(eight, {1000}, {}), 8592);
  EXPECT_EQ(cost(eight, {1000}, {{A, {0, 1, 2, 3, 4, 5, 6, 7}}}), 1122);
  EXPECT_EQ(cost(halves, {10'000, 10'000}, {}), 83'376);
  EXPECT_EQ(cost(halves, {10'000, 10'000}, {{A, {0, 1, 2, 3}}, {B, {4, 5, 6, 7}}}), 20'908);
  EXPECT_EQ(cost({A, B}, {8, 8}, {{A | B, {0, 1}}}), 118);
  EXPECT_EQ(cost({A, A, B}, {10'000, 8}, {{A, {0, 1}}}), 10'528);
}

struct Case {
  const char* what;
  std::vector<MaskSet> masks;  ///< of each destination
  std::vector<double> bytes;   ///< of each mask
  MulticastPlan best;
};

TEST(MulticastPlan, IsTheCheapestOfEachCase) {
  const std::vector<Case> cases{
      {"nobody", {}, {100}, {}},
      {"one reader", {A}, {1000}, {}},
      {"one process with two masks", {A | B}, {1000, 1000}, {}},
      {"two that ask for the same", {A, A}, {1000}, {{A, {0, 1}}}},
      {"eight, two masks: two groups",
       {A, B, A, B, A, B, A, B},
       {10'000, 10'000},
       {{A, {0, 2, 4, 6}}, {B, {1, 3, 5, 7}}}},
      {"two small masks: their headers cost more than the other fields", {A, B}, {8, 8}, {{A | B, {0, 1}}}},
      {"two large ones that have nothing in common", {A, B}, {10'000, 10'000}, {}},
      {"a large one and one that asks for a few of its bytes", {A, A, B}, {10'000, 8}, {{A, {0, 1}}}},
      {"one process asks for what two others ask for", {A, B, A | B}, {1000, 1000}, {{A | B, {0, 1, 2}}}},
  };
  for (const Case& c : cases) EXPECT_EQ(plan(c.masks, apart(c.bytes)), c.best) << c.what;
}

TEST(MulticastPlan, HasGroupsBehindOneLinkOnly) {
  std::vector<PlanDestination> all = destinations({A, A, A, A});
  all[1].link = all[3].link = 1;
  const MulticastPlan best{{A, {0, 2}}, {A, {1, 3}}};
  EXPECT_EQ(plan_multicast(all, apart({1000}), often, {}, {}), best);
  all[2].link = 2;
  EXPECT_EQ(plan_multicast(all, apart({1000}), often, {}, {}), (MulticastPlan{{A, {1, 3}}}));
}

TEST(MulticastPlan, TakesInWhoJoinsAndGoesOnWithoutWhoLeaves) {
  const BodyBytes bytes = apart({1000});
  const MulticastPlan two = plan({A, A}, bytes);
  const MulticastPlan three = plan({A, A, A}, bytes, two);
  EXPECT_EQ(three, (MulticastPlan{{A, {0, 1, 2}}}));
  EXPECT_EQ(plan({A, A}, bytes, {{A, {0, 1}}}), two);
}

TEST(MulticastPlan, FollowsAMaskThatChanges) {
  const BodyBytes bytes = apart({10'000, 10'000});
  EXPECT_EQ(plan({A, A, A}, bytes), (MulticastPlan{{A, {0, 1, 2}}}));
  EXPECT_EQ(plan({A, A, B}, bytes, {{A | B, {0, 1, 2}}}), (MulticastPlan{{A, {0, 1}}}))
      << "it is sent too much";
}

TEST(MulticastPlan, StaysAsItIsForASmallGain) {
  // 16 * 100 bytes less for one of many is nothing to change the groups for.
  const std::vector<MaskSet> masks{A, A, A, A, B, B};
  const MulticastPlan present{{A, {0, 1, 2, 3}}};
  EXPECT_EQ(plan(masks, apart({100'000, 100}), present), present);
  EXPECT_EQ(plan(masks, apart({100'000, 100'000}), present), (MulticastPlan{{A, {0, 1, 2, 3}}, {B, {4, 5}}}));
}

TEST(MulticastPlan, DoesNotFlapWhileSizesVary) {
  std::mt19937 random(1);
  MulticastPlan present;
  int changes = 0;
  for (int i = 0; i < 1000; ++i) {  // around where a group of both begins to pay
    const double b = 28 + static_cast<double>(random() % 9);
    MulticastPlan next = plan({A, B}, apart({30, b}), present);
    changes += next == present ? 0 : 1;
    present = std::move(next);
  }
  EXPECT_LE(changes, 1);
}

TEST(MulticastPlan, HasNoGroupForATopicThatIsSeldomSent) {
  const std::vector<PlanDestination> all = destinations({A, A, A, A, A, A, A, A});
  EXPECT_TRUE(plan_multicast(all, apart({100}), 1, {}, {}).empty());
  EXPECT_FALSE(plan_multicast(all, apart({100}), 100, {}, {}).empty());
}

TEST(MulticastPlan, CountsWhatMembersGetAndHaveNotAskedFor) {
  // A group of all would put 10 % less on the wire than two groups, and bring two members what they do not
  // want.
  const std::vector<PlanDestination> all = destinations({A, A, B, B});
  PlanLimits indifferent;
  indifferent.unwanted_weight = 0;
  const BodyBytes nearly_equal = [](MaskSet set) {
    return set == (A | B) ? 1200.0 : set == A ? 1100.0 : 300.0;
  };
  EXPECT_EQ(plan_multicast(all, nearly_equal, often, {}, indifferent).size(), 1U);
  EXPECT_EQ(plan_multicast(all, nearly_equal, often, {}, {}).size(), 2U);
}

/// Each partition of single destinations, into groups or alone, that treats equal ones alike.
class BruteForce {
 public:
  BruteForce(const std::vector<PlanDestination>& all, const BodyBytes& bytes) : all_(all), bytes_(bytes) {
    place(0);
  }
  double best_cost() const { return best_; }

 private:
  void place(std::size_t next) {
    if (next == all_.size()) {
      const bool sound =
          std::ranges::all_of(plan_, [](const auto& group) { return group.members.size() > 1; });
      if (sound && treats_equals_alike()) best_ = std::min(best_, plan_cost(all_, bytes_, plan_, {}));
      return;
    }
    place(next + 1);
    for (std::size_t i = 0; i <= plan_.size() && i < PlanLimits{}.groups_max; ++i) {
      const MulticastPlan before = plan_;
      if (i == plan_.size()) plan_.emplace_back();
      plan_[i].masks |= all_[next].masks;
      plan_[i].members.push_back(next);
      if (all_[plan_[i].members[0]].link == all_[next].link) place(next + 1);
      plan_ = before;
    }
  }
  /// -1: alone
  std::ptrdiff_t group_of(std::size_t destination) const {
    const auto found = std::ranges::find_if(
        plan_, [&](const auto& group) { return std::ranges::count(group.members, destination) > 0; });
    return found == plan_.end() ? -1 : found - plan_.begin();
  }
  bool treats_equals_alike() const {
    for (std::size_t i = 0; i < all_.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        const bool equal = all_[i].masks == all_[j].masks && all_[i].link == all_[j].link;
        if (equal && group_of(i) != group_of(j)) return false;
      }
    }
    return true;
  }

  const std::vector<PlanDestination>& all_;
  const BodyBytes& bytes_;
  MulticastPlan plan_;
  double best_ = plan_cost(all_, bytes_, {}, {});
};

class MulticastPlanTest : public sft::test::RandomTest {};

TEST_F(MulticastPlanTest, CostsAsLittleAsTheBestOfAllPartitionsThatTreatEqualsAlike) {
  for (int i = 0; i < 200; ++i) {
    std::vector<PlanDestination> all;
    for (std::size_t n = 1 + random() % 6; n > 0; --n)
      all.push_back({.masks = static_cast<MaskSet>(1 + random() % 7),
                     .link = random() % 8 / 7,
                     .datagram_bytes = random() % 2 == 0 ? 1472U : 1000U,
                     .reliable = false});
    std::ranges::for_each(all, [&](PlanDestination& to) { to.datagram_bytes = all[0].datagram_bytes; });
    const auto size = [&] { return static_cast<double>(8U << random() % 12); };
    const BodyBytes bytes = apart({size(), size(), size()});
    PlanLimits any_gain;
    any_gain.gain_min = 0;
    any_gain.gain_bytes_per_s = 0;
    const MulticastPlan best = plan_multicast(all, bytes, often, {}, any_gain);
    ASSERT_DOUBLE_EQ(plan_cost(all, bytes, best, {}), BruteForce(all, bytes).best_cost()) << "case " << i;
  }
}

}  // namespace
}  // namespace sft::udp
