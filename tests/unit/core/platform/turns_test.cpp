// Every participant gets a turn, even if only a few of them can be served at a time.
#include "core/platform/turns.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <set>
#include <vector>

namespace sft::core {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

std::vector<int> next_of(Turns<int>& turns, const std::set<int>& all, std::size_t most) {
  std::vector<int> taken;
  turns.go_round(all, most, [&](int key) {
    taken.push_back(key);
    return true;
  });
  return taken;
}

TEST(TurnsTest, AllHaveATurnAtOnceWhereTheyFitIn) {
  Turns<int> turns;
  EXPECT_THAT(next_of(turns, {3, 1, 2}, 3), ElementsAre(1, 2, 3));
  EXPECT_THAT(next_of(turns, {3, 1, 2}, 3), ElementsAre(1, 2, 3));
  EXPECT_THAT(next_of(turns, {}, 3), IsEmpty());
}

TEST(TurnsTest, TheNextRoundBeginsBehindTheLastOneThoughOthersHaveComeAndGone) {
  Turns<int> turns;
  EXPECT_THAT(next_of(turns, {1, 2, 3, 4, 5}, 2), ElementsAre(1, 2));
  EXPECT_THAT(next_of(turns, {1, 3, 4, 5}, 2), ElementsAre(3, 4)) << "2 is gone";
  EXPECT_THAT(next_of(turns, {1, 3, 4, 5, 6}, 3), ElementsAre(5, 6, 1));
}

TEST(TurnsTest, WhoDoesNotTakeItsTurnIsPassedOverAndDoesNotCount) {
  Turns<int> turns;
  std::map<int, bool> wants{{1, false}, {2, true}, {3, false}, {4, true}, {5, true}};
  std::vector<int> taken;
  const auto take = [&](auto& item) {
    if (item.second) taken.push_back(item.first);
    return std::exchange(item.second, false);
  };
  turns.go_round(wants, 2, take);
  EXPECT_THAT(taken, ElementsAre(2, 4));
  wants[2] = true;
  turns.go_round(wants, 1, take);
  EXPECT_THAT(taken, ElementsAre(2, 4, 5));
  turns.go_round(wants, 9, take);
  EXPECT_THAT(taken, ElementsAre(2, 4, 5, 2));
}

}  // namespace
}  // namespace sft::core
