#include "core/platform/retry.h"

#include <gtest/gtest.h>

namespace sft::core {
namespace {

using namespace std::chrono_literals;
constexpr Time start{1000s};

TEST(RetryTest, WhatHasNotFailedMayBeTriedAndIsNotTriedAgain) {
  const Retry retry;
  EXPECT_TRUE(retry.due(start));
  EXPECT_FALSE(retry.due_again(start));
}

TEST(RetryTest, PausesDoubleUpToALimit) {
  Retry retry;
  Time now = start;
  for (const auto pause : {500ms, 1000ms, 2000ms, 4000ms, 8000ms, 10'000ms, 10'000ms}) {
    retry.failed("no", now);
    EXPECT_FALSE(retry.due(now + pause - 1ms));
    now += pause;
    EXPECT_TRUE(retry.due_again(now));
  }
}

TEST(RetryTest, AReasonIsNewsUntilItIsTheSame) {
  Retry retry;
  EXPECT_TRUE(retry.failed("no memory", start));
  EXPECT_FALSE(retry.failed("no memory", start));
  EXPECT_TRUE(retry.failed("no answer", start));
}

TEST(RetryTest, AfterASuccessAllBeginsAnew) {
  Retry retry;
  retry.failed("no", start);
  retry.failed("no", start);
  retry.succeeded();
  EXPECT_FALSE(retry.due_again(start + 1h));
  EXPECT_TRUE(retry.failed("no", start));
  EXPECT_TRUE(retry.due(start + Retry::pause_min));
}

}  // namespace
}  // namespace sft::core
