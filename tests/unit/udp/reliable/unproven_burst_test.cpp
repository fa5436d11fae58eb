#include "udp_transport/reliable/unproven_burst.h"

#include <gtest/gtest.h>

namespace sft::udp {
namespace {

using namespace std::chrono_literals;

constexpr UnprovenBurst::Time now{1h};

TEST(UnprovenBurstTest, AwaitsAReportOnlyOnceAJobWasPostedWithoutOne) {
  UnprovenBurst burst;
  EXPECT_FALSE(burst.awaits_report());
  EXPECT_FALSE(burst.is_just_reported(now));
  burst.await_report(true);
  EXPECT_TRUE(burst.awaits_report());
  EXPECT_FALSE(burst.is_just_reported(now));
}

TEST(UnprovenBurstTest, GoesOnForAMomentAfterTheReport) {
  UnprovenBurst burst;
  burst.await_report(true);
  burst.reported(now);
  EXPECT_FALSE(burst.awaits_report());
  EXPECT_TRUE(burst.is_just_reported(now));
  EXPECT_TRUE(burst.is_just_reported(now + UnprovenBurst::goes_on - 1ns));
  EXPECT_FALSE(burst.is_just_reported(now + UnprovenBurst::goes_on));
}

TEST(UnprovenBurstTest, DoesNotGoOnIfNoSmallJobsHaveWaited) {
  UnprovenBurst burst;
  burst.await_report(false);
  burst.reported(now);
  EXPECT_FALSE(burst.awaits_report());
  EXPECT_FALSE(burst.is_just_reported(now));
}

TEST(UnprovenBurstTest, RemembersASmallJobBeforeLargeOnes) {
  UnprovenBurst burst;
  burst.await_report(true);
  burst.await_report(false);
  burst.reported(now);
  EXPECT_TRUE(burst.is_just_reported(now));
}

TEST(UnprovenBurstTest, BeginsAnewIfTheReceiverFallsSilentAgain) {
  UnprovenBurst burst;
  burst.await_report(true);
  burst.reported(now);
  burst.await_report(false);
  EXPECT_TRUE(burst.awaits_report());
  EXPECT_FALSE(burst.is_just_reported(now));
  burst.reported(now);
  EXPECT_FALSE(burst.is_just_reported(now)) << "only a large job has waited this time";
}

}  // namespace
}  // namespace sft::udp
