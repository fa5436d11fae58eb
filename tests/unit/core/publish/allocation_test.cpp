// In steady state, neither shrinking a loan nor recording read accesses allocates memory.
#include <gtest/gtest.h>

#include <views.hpp>

#include "core/subscribe/recorder.h"
#include "tests/support/thread_allocations.h"
#include "tests/unit/core/publish/publisher_fixture.h"

namespace sft::core::test {
namespace {

using views::Recording;
using F = Recording::Field;

TEST(LoanAllocations, ReservingFillingShrinkingAndPublishingAllocateNothing) {
  PublisherOf<Recording> publisher;
  Recording prototype;
  prototype.tracks.resize(3);
  const auto exchange = [&] {
    auto loan = publisher->loan(prototype, {.stamps = 100, .cloud = {.data = 100'000}}).value();
    loan->stamps()[0] = 1;
    loan.shrink(F::stamps, 7);
    loan.shrink(F::cloud.data, 50'000);
    EXPECT_EQ(std::move(loan).publish(), PublishStatus::ok);
  };
  for (int i = 0; i < 10; ++i) exchange();
  const std::uint64_t before = sft::test::thread_allocations();
  for (int i = 0; i < 100; ++i) exchange();
  EXPECT_EQ(sft::test::thread_allocations() - before, 0U);
}

TEST(RecorderAllocations, ReadingWideningAndNarrowingAllocateNothing) {
  constexpr std::size_t leaves = 1000;
  int changes = 0;
  const auto recorder =
      Recorder::make(leaves, {.learn_samples = 2, .narrow_after_samples = 3}, [&] { ++changes; });
  std::size_t n = 0;
  const auto read = [&] {
    RecordedSample* const first = recorder->begin();
    RecordedSample* const second = recorder->begin();
    first->log().touch(++n * 7 % leaves, true);
    second->log().touch(n * 13 % leaves, false);
    Recorder::end(first);
    Recorder::end(second);
  };
  for (int i = 0; i < 10; ++i) read();
  const std::uint64_t before = sft::test::thread_allocations();
  for (int i = 0; i < 1000; ++i) read();
  EXPECT_EQ(sft::test::thread_allocations() - before, 0U);
  EXPECT_GT(changes, 1000);
}

}  // namespace
}  // namespace sft::core::test
