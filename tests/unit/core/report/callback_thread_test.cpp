// The number of calls that wait for the thread for callbacks of events is limited.
#include "core/report/callback_thread.h"

#include <gtest/gtest.h>

#include <atomic>
#include <future>

#include "tests/support/eventually.h"

namespace sft::core {
namespace {

TEST(CallbackThreadTest, LeavesOutTheCallsBeyondTenThousandEachTimeThatACallbackDoesNotReturn) {
  constexpr std::uint64_t waiting_max = 10'000, too_many = 7;
  CallbackThread thread({"test", {}});
  ASSERT_TRUE(thread.start());
  std::atomic<std::uint64_t> called{0};
  for (std::uint64_t round = 1; round <= 3; ++round) {
    std::promise<void> begun, may_return;
    thread.post([&begun, returns = may_return.get_future().share()] {
      begun.set_value();
      returns.wait();
    });
    begun.get_future().wait();
    for (std::uint64_t i = 0; i < waiting_max + too_many; ++i) thread.post([&] { ++called; });
    EXPECT_EQ(thread.take_left_out(), 0U) << "no callback can report it now";
    may_return.set_value();
    ASSERT_TRUE(test::eventually([&] { return called == round * waiting_max; })) << called;
    EXPECT_EQ(thread.take_left_out(), too_many);
    EXPECT_EQ(thread.take_left_out(), 0U) << "the number is reported once";
  }
  thread.stop();
}

}  // namespace
}  // namespace sft::core
