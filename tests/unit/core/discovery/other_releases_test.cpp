// Nodes of other releases are named, and not too often.
#include "core/discovery/other_releases.h"

#include <gtest/gtest.h>

#include <vector>

namespace sft::core {
namespace {

using namespace std::chrono_literals;

class OtherReleasesTest : public ::testing::Test {
 protected:
  static Speaker speaker(AnnouncerId participant) { return {.link = 1, .participant = participant}; }
  std::optional<OtherReleases::Report> after(std::chrono::seconds time) {
    return releases.take_report(now += time);
  }

  Time now{1h};
  OtherReleases releases;
};

TEST_F(OtherReleasesTest, AreReportedAtOnceAndEachOnlyOnce) {
  EXPECT_FALSE(after(0s));
  releases.seen(speaker(1), 7);
  const auto report = after(0s);
  ASSERT_TRUE(report);
  EXPECT_EQ(report->speaker, speaker(1));
  EXPECT_EQ(report->version, 7U);
  EXPECT_EQ(report->others, 0U);
  releases.seen(speaker(1), 7);
  EXPECT_FALSE(after(3600s));
}

TEST_F(OtherReleasesTest, ThatComeSoonAfterAReportWaitForTheNextOneWhichCountsThem) {
  releases.seen(speaker(1), 7);
  ASSERT_TRUE(after(0s));
  for (AnnouncerId participant = 2; participant < 7; ++participant) releases.seen(speaker(participant), 9);
  EXPECT_FALSE(after(59s));
  const auto report = after(1s);
  ASSERT_TRUE(report);
  EXPECT_EQ(report->version, 9U);
  EXPECT_EQ(report->others, 4U);
  EXPECT_FALSE(after(60s));
}

TEST_F(OtherReleasesTest, ThatComeAgainUnderAnotherIdentityAreReportedAgain) {
  releases.seen(speaker(1), 7);
  ASSERT_TRUE(after(0s));
  releases.departed(speaker(1));
  releases.seen(speaker(2), 7);
  EXPECT_TRUE(after(60s));
}

TEST_F(OtherReleasesTest, ThatSomebodyMakesUpAreOneReportAMinuteAndLittleMemory) {
  int reports = 0;
  for (AnnouncerId participant = 1; participant < 100'000; ++participant) {
    releases.seen(speaker(participant), 7);
    if (participant % 1000 == 0) reports += after(1s) ? 1 : 0;
  }
  EXPECT_EQ(reports, 1);
}

TEST_F(OtherReleasesTest, AreDescribedByVersionAndInterfaceAndWhatToDo) {
  EXPECT_EQ(describe({.speaker = speaker(1), .version = 7}, "eth0", 10),
            "a participant with control protocol 7 is on eth0; this node has 10; they do not see each other: "
            "use the same release");
  EXPECT_EQ(
      describe({.speaker = speaker(1), .version = 11, .others = 12}, "wlan0", 10),
      "a participant with control protocol 11 is on wlan0; this node has 10; they do not see each other: "
      "use the same release (12 more with another protocol have come)");
}

}  // namespace
}  // namespace sft::core
