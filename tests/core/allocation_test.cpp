// In steady state a loan that shrinks allocates nothing.
#include <gtest/gtest.h>

#include <views.hpp>

#include "tests/core/publisher_fixture.h"
#include "tests/support/thread_allocations.h"

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

}  // namespace
}  // namespace sft::core::test
