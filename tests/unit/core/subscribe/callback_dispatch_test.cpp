// Tests which thread runs a subscriber's callback, and from when on no thread runs the callback.
#include "core/subscribe/callback_dispatch.h"

#include <gtest/gtest.h>

#include <deque>
#include <functional>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <thread>

#include "core/seam/buffer_pool.h"
#include "tests/support/eventually.h"

namespace sft::core {
namespace {

using namespace detail;

using sensor_msgs::msg::PointCloud2;
using Caller = CallbackDispatch::Caller;

class CallbackDispatchTest : public ::testing::Test {
 protected:
  /// A source of `count` samples that have arrived and were not taken.
  struct Samples {
    untyped::Sample take() {
      if (count == 0) return {};
      --count;
      SampleHandle sample = pool->take(256);
      sample->mask = type.full();
      return untyped::Sample(sample.release(), type, {}, nullptr);
    }
    bool available() {
      if (on_look) std::exchange(on_look, {})();
      return count > 0;
    }

    const TypeSupport type{TypeTable<PointCloud2>::type};
    const std::shared_ptr<BufferPool> pool = BufferPool::make(1 << 20);
    int count = 0;
    std::function<void()> on_look;  ///< called once, when available() is called next
  };

  bool dispatch(Caller caller) { return callbacks.dispatch(caller, samples); }
  static void take_long() { now += std::chrono::milliseconds(1); }
  static Time read_now() { return now; }

  static inline Time now{};  ///< a test must advance this time itself

  Samples samples;
  int calls = 0;
  std::function<void()> in_callback;
  const untyped::Callback callback = [this](untyped::Sample&&) {
    ++calls;
    if (in_callback) in_callback();
  };
  CallbackDispatch callbacks{callback, &read_now};
};

TEST_F(CallbackDispatchTest, EverySampleIsCalledBackFor) {
  samples.count = 3;
  EXPECT_TRUE(dispatch(Caller::transport));
  EXPECT_EQ(calls, 3);
  EXPECT_TRUE(callbacks.is_idle());
}

TEST_F(CallbackDispatchTest, AThreadKnowsThatItIsWithinACallbackOfAnySubscriber) {
  bool inside = false;
  in_callback = [&] { inside = CallbackDispatch::in_callback(); };
  samples.count = 1;
  dispatch(Caller::transport);
  EXPECT_TRUE(inside);
  EXPECT_FALSE(CallbackDispatch::in_callback());
}

TEST_F(CallbackDispatchTest, ASampleThatArrivesWithinACallbackIsCalledBackForAfterIt) {
  int depth = 0;
  in_callback = [&] {
    EXPECT_EQ(depth++, 0);
    if (calls == 1) {
      ++samples.count;
      EXPECT_TRUE(dispatch(Caller::transport)) << "the outer call goes on";
      EXPECT_EQ(calls, 1);
    }
    --depth;
  };
  samples.count = 1;
  dispatch(Caller::transport);
  EXPECT_EQ(calls, 2);
}

// If a thread finds a sample while the last callback ends, it leaves the sample to the thread that
// dispatches.
TEST_F(CallbackDispatchTest, ASampleThatArrivesJustAfterTheLastCallbackIsNotForgotten) {
  samples.on_look = [&] { ++samples.count; };
  EXPECT_TRUE(dispatch(Caller::transport));
  EXPECT_EQ(calls, 1);
}

TEST_F(CallbackDispatchTest, AfterASlowCallbackTheRestIsForTheDispatcher) {
  in_callback = [&] {
    if (calls == 1) take_long();
  };
  samples.count = 2;
  EXPECT_FALSE(dispatch(Caller::transport));
  EXPECT_EQ(calls, 1);
  EXPECT_TRUE(callbacks.is_slow());
  EXPECT_TRUE(callbacks.is_idle());
  EXPECT_TRUE(dispatch(Caller::dispatcher));
  EXPECT_EQ(calls, 2);
}

TEST_F(CallbackDispatchTest, AfterAHundredQuickCallbacksInARowTheyAreQuickAgain) {
  in_callback = [&] {
    if (calls == 1) take_long();
  };
  samples.count = 1;
  dispatch(Caller::transport);
  samples.count = 99;
  dispatch(Caller::dispatcher);
  EXPECT_TRUE(callbacks.is_slow());
  samples.count = 1;
  dispatch(Caller::dispatcher);
  EXPECT_FALSE(callbacks.is_slow());
  EXPECT_EQ(calls, 101);
}

TEST_F(CallbackDispatchTest, ASubscriberWhoseCallbacksTakeLongHasOneInEachTurn) {
  in_callback = take_long;
  samples.count = 3;
  EXPECT_FALSE(dispatch(Caller::dispatcher));
  EXPECT_EQ(calls, 1);
  EXPECT_FALSE(dispatch(Caller::dispatcher));
  EXPECT_EQ(calls, 2);
  EXPECT_TRUE(callbacks.is_idle()) << "the next turn is the dispatcher's business";
}

TEST_F(CallbackDispatchTest, QuickCallbacksEndTheirTurnTogetherEvenIfTheNextSampleIsAlwaysThere) {
  in_callback = [&] {
    now += std::chrono::microseconds(CallbackDispatch::turn) / 10;
    ++samples.count;
  };
  samples.count = 1;
  for (const auto caller : {Caller::transport, Caller::dispatcher}) {
    calls = 0;
    EXPECT_FALSE(dispatch(caller));
    EXPECT_EQ(calls, 10);
  }
}

TEST_F(CallbackDispatchTest, ItIsKnownWhetherTheThreadThatReceivesIsHeldUp) {
  const auto held_up = [&](Caller caller) {
    bool is_held_up = false;
    in_callback = [&] { is_held_up = callbacks.holds_up_transport(); };
    samples.count = 1;
    dispatch(caller);
    return is_held_up;
  };
  EXPECT_TRUE(held_up(Caller::transport));
  EXPECT_FALSE(callbacks.holds_up_transport()) << "no callback runs";
  EXPECT_FALSE(held_up(Caller::dispatcher));
}

TEST_F(CallbackDispatchTest, OnceItIsClosedNobodyIsCalledBack) {
  in_callback = [&] {
    callbacks.close();  // returns at once, since it is called within the callback
  };
  samples.count = 2;
  dispatch(Caller::transport);
  EXPECT_EQ(calls, 1);
  dispatch(Caller::dispatcher);
  EXPECT_EQ(calls, 1);
  EXPECT_FALSE(callbacks.is_idle());
}

TEST_F(CallbackDispatchTest, WhoeverClosesItWaitsForTheCallbackOfAnotherThread) {
  std::atomic<bool> goes_on{false}, ended{false};
  std::atomic<bool> begun{false};
  in_callback = [&] {
    begun = true;
    EXPECT_TRUE(sft::test::eventually([&] { return goes_on.load(); }));
    ended = true;
  };
  samples.count = 1;
  std::thread transport([&] { dispatch(Caller::transport); });
  EXPECT_TRUE(sft::test::eventually([&] { return begun.load(); }));
  EXPECT_TRUE(callbacks.is_called_back());
  goes_on = true;
  callbacks.close();
  EXPECT_TRUE(ended);
  EXPECT_FALSE(callbacks.is_called_back());
  transport.join();
}

}  // namespace
}  // namespace sft::core
