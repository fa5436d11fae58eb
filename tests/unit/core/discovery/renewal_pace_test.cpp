// Links are made anew neither too often nor too seldom.
#include "core/discovery/renewal_pace.h"

#include <gtest/gtest.h>

namespace sft::core {
namespace {

using namespace std::chrono_literals;

class RenewalPaceTest : public ::testing::Test {
 protected:
  /// Returns how often the link is made anew if that is needed `after` each time, for so long; and the
  /// longest pause.
  int renewals(std::chrono::milliseconds duration, std::chrono::milliseconds after) {
    int count = 0;
    longest = 0ms;
    auto last = now;
    for (const auto end = now + duration; now < end; now += 100ms) {
      const bool is_needed = count == 0 || now - last >= after;
      if (!is_needed || !pace.is_needed(now)) continue;
      if (count > 0)
        longest = std::max(longest, std::chrono::duration_cast<std::chrono::milliseconds>(now - last));
      pace.renewed(now);
      last = now;
      ++count;
    }
    return count;
  }

  RenewalPace pace;
  Time now{1000s};
  std::chrono::milliseconds longest{};
};

TEST_F(RenewalPaceTest, WhereItDoesNotHelpItIsDoneEverMoreSeldom) {
  EXPECT_EQ(renewals(10s, 0ms), 5);  // after 0.5, 1, 2 and 4 s
  EXPECT_LE(renewals(200s, 0ms), 11);
  EXPECT_EQ(longest, 20s);
}

TEST_F(RenewalPaceTest, WhereItHelpsForAWhileItComesAgainBeforeALeaseIsOver) {
  renewals(60s, 0ms);
  renewals(60s, 1500ms);
  EXPECT_EQ(longest, 2s);
}

TEST_F(RenewalPaceTest, WhoeverIsMissedBeforeItCanHaveHelpedDoesNotMakeItComeSooner) {
  renewals(60s, 0ms);
  renewals(60s, 900ms);
  EXPECT_EQ(longest, 20s);
}

TEST_F(RenewalPaceTest, AfterTwoQuietMinutesItBeginsAnew) {
  renewals(200s, 0ms);
  now += 121s;
  EXPECT_EQ(renewals(10s, 0ms), 5);
}

TEST_F(RenewalPaceTest, IsDoneAtOnceTheFirstTime) { EXPECT_TRUE(pace.is_needed(now)); }

}  // namespace
}  // namespace sft::core
