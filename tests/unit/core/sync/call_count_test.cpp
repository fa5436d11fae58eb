#include "core/sync/call_count.h"

#include <gtest/gtest.h>

#include <future>
#include <memory>
#include <optional>
#include <thread>
#include <utility>

#include "core/sync/snapshot.h"

namespace sft::core {
namespace {

using namespace std::chrono_literals;

TEST(CallCountTest, WithoutACallThereIsNothingToWaitFor) {
  CallCount calls;
  calls.wait_for_present_call();
  { const CallCount::Call call(calls); }
  calls.wait_for_present_call();
}

TEST(CallCountTest, TheCallUnderWayIsWaitedForAndTheNextOneIsNot) {
  CallCount calls;
  std::optional<CallCount::Call> call(std::in_place, calls);
  auto waiting = std::async(std::launch::async, [&] { calls.wait_for_present_call(); });
  EXPECT_EQ(waiting.wait_for(50ms), std::future_status::timeout);
  call.reset();
  call.emplace(calls);
  EXPECT_EQ(waiting.wait_for(10s), std::future_status::ready);
  call.reset();
}

TEST(CallCountTest, AfterTheWaitNoCallUsesWhatWasReplacedBefore) {
  using Alive = std::atomic<bool>;
  CallCount calls;
  Snapshot<Alive> latest;
  auto present = std::make_shared<Alive>(true);
  latest.store(present);
  std::atomic<bool> stop{false};
  std::uint64_t dead = 0;
  std::thread caller([&] {
    while (!stop) {
      const CallCount::Call call(calls);
      const Alive* value = latest.load();
      for (int i = 0; i < 10; ++i) dead += value->load(std::memory_order_relaxed) ? 0 : 1;
    }
  });
  for (int i = 0; i < 2000; ++i) {
    const auto before = std::exchange(present, std::make_shared<Alive>(true));
    latest.store(present);
    calls.wait_for_present_call();
    before->store(false, std::memory_order_relaxed);
  }
  stop = true;
  caller.join();
  EXPECT_EQ(dead, 0U);
}

}  // namespace
}  // namespace sft::core
