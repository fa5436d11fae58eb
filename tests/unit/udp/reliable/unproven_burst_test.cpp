#include "udp_transport/reliable/unproven_burst.h"

#include <gtest/gtest.h>

#include "tests/unit/udp/start.h"

namespace sft::udp {
namespace {

using namespace std::chrono_literals;

TEST(UnprovenBurstTest, AwaitsAReportOnlyOnceAJobWasPostedWithoutOne) {
  UnprovenBurst burst;
  EXPECT_FALSE(burst.awaits_report());
  EXPECT_FALSE(burst.is_just_reported(test_start));
  burst.await_report(true);
  EXPECT_TRUE(burst.awaits_report());
  EXPECT_FALSE(burst.is_just_reported(test_start));
}

TEST(UnprovenBurstTest, GoesOnForAMomentAfterTheReport) {
  UnprovenBurst burst;
  burst.await_report(true);
  burst.reported(test_start);
  EXPECT_FALSE(burst.awaits_report());
  EXPECT_TRUE(burst.is_just_reported(test_start));
  EXPECT_TRUE(burst.is_just_reported(test_start + UnprovenBurst::goes_on - 1ns));
  EXPECT_FALSE(burst.is_just_reported(test_start + UnprovenBurst::goes_on));
}

TEST(UnprovenBurstTest, DoesNotGoOnIfNoSmallJobsHaveWaited) {
  UnprovenBurst burst;
  burst.await_report(false);
  burst.reported(test_start);
  EXPECT_FALSE(burst.awaits_report());
  EXPECT_FALSE(burst.is_just_reported(test_start));
}

TEST(UnprovenBurstTest, RemembersASmallJobBeforeLargeOnes) {
  UnprovenBurst burst;
  burst.await_report(true);
  burst.await_report(false);
  burst.reported(test_start);
  EXPECT_TRUE(burst.is_just_reported(test_start));
}

TEST(UnprovenBurstTest, BeginsAnewIfTheReceiverFallsSilentAgain) {
  UnprovenBurst burst;
  burst.await_report(true);
  burst.reported(test_start);
  burst.await_report(false);
  EXPECT_TRUE(burst.awaits_report());
  EXPECT_FALSE(burst.is_just_reported(test_start));
  burst.reported(test_start);
  EXPECT_FALSE(burst.is_just_reported(test_start)) << "only a large job has waited this time";
}

}  // namespace
}  // namespace sft::udp
