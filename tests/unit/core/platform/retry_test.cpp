#include "core/platform/retry.h"

#include <gtest/gtest.h>

#include "tests/unit/core/start.h"

namespace sft::core {
namespace {

using namespace std::chrono_literals;

TEST(RetryTest, WhatHasNotFailedMayBeTriedAndIsNotTriedAgain) {
  const Retry retry;
  EXPECT_TRUE(retry.due(test_start));
  EXPECT_FALSE(retry.due_again(test_start));
}

TEST(RetryTest, PausesDoubleUpToALimit) {
  Retry retry;
  Time now = test_start;
  for (const auto pause : {500ms, 1000ms, 2000ms, 4000ms, 8000ms, 10'000ms, 10'000ms}) {
    retry.failed("no", now);
    EXPECT_FALSE(retry.due(now + pause - 1ms));
    now += pause;
    EXPECT_TRUE(retry.due_again(now));
  }
}

TEST(RetryTest, AReasonIsNewsUntilItIsTheSame) {
  Retry retry;
  EXPECT_TRUE(retry.failed("no memory", test_start));
  EXPECT_FALSE(retry.failed("no memory", test_start));
  EXPECT_TRUE(retry.failed("no answer", test_start));
}

TEST(RetryTest, AfterASuccessAllBeginsAnew) {
  Retry retry;
  retry.failed("no", test_start);
  retry.failed("no", test_start);
  retry.succeeded();
  EXPECT_FALSE(retry.due_again(test_start + 1h));
  EXPECT_TRUE(retry.failed("no", test_start));
  EXPECT_TRUE(retry.due(test_start + Retry::pause_min));
}

}  // namespace
}  // namespace sft::core
