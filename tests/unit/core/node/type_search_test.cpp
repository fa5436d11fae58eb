#include "core/node/type_search.h"

#include <gtest/gtest.h>

namespace sft::core {
namespace {

using namespace std::chrono_literals;

constexpr Time called{1h};

TEST(TypeSearchTest, ReadersAreHeardAfterASecondInWhichNoPublisherCame) {
  TypeSearch search(called, called + 5s);
  EXPECT_FALSE(search.hears_readers());
  EXPECT_EQ(search.waits_until(), called + 1s);
  EXPECT_TRUE(search.goes_on(called + 1s, {}));
  EXPECT_TRUE(search.hears_readers());
  EXPECT_EQ(search.waits_until(), called + 5s);
  EXPECT_FALSE(search.goes_on(called + 5s, {}));
}

TEST(TypeSearchTest, ReadersAreNotHeardWhileProcessesAreBeingDiscovered) {
  TypeSearch search(called, called + 10s);
  EXPECT_TRUE(search.goes_on(called + 1s, called + 900ms));
  EXPECT_FALSE(search.hears_readers());
  EXPECT_EQ(search.waits_until(), called + 1900ms);
  EXPECT_TRUE(search.goes_on(called + 1900ms, called + 900ms));
  EXPECT_TRUE(search.hears_readers());
}

TEST(TypeSearchTest, ReadersHaveHalfOfTheTimeToTellTheTypeHoweverManyProcessesStart) {
  TypeSearch search(called, called + 8s);
  EXPECT_TRUE(search.goes_on(called + 3900ms, called + 3800ms));
  EXPECT_EQ(search.waits_until(), called + 4s);
  EXPECT_TRUE(search.goes_on(called + 4s, called + 3999ms));
  EXPECT_TRUE(search.hears_readers());
}

TEST(TypeSearchTest, ReadersAreHeardAfterFiveSecondsThoughTheSearchHasNoEndAndProcessesComeAllTheTime) {
  TypeSearch search(called, Time::max());
  Time now = called;
  while (!search.hears_readers() && now < called + 1min) {
    now = search.waits_until();
    ASSERT_TRUE(search.goes_on(now, now - 10ms));
  }
  EXPECT_EQ(now, called + 5s);
}

TEST(TypeSearchTest, ReadersAreHeardAtOnceWhereThereIsNoTimeToWait) {
  EXPECT_TRUE(TypeSearch(called, called + 1s).hears_readers());
  EXPECT_FALSE(TypeSearch(called, Time::max()).hears_readers());
}

}  // namespace
}  // namespace sft::core
