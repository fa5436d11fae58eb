// Tests that a callback is not called any more after it was cleared, whichever threads call and clear it.
#include "core/sync/guarded_call.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <functional>
#include <latch>
#include <memory>
#include <stdexcept>
#include <thread>
#include <vector>

namespace sft::core {
namespace {

/// Waits until another thread has set the flag. If no thread sets it, the test hangs until its time limit
/// ends it.
void wait_for(const std::atomic<bool>& flag) { flag.wait(false); }
void set(std::atomic<bool>& flag) {
  flag = true;
  flag.notify_all();
}

TEST(GuardedCallTest, CallsItsFunctionWithTheArgumentsUntilItIsCleared) {
  int sum = 0;
  GuardedCall<int, int> call([&](int a, int b) { sum += a * b; });
  call(2, 3);
  EXPECT_TRUE(call.is_set());
  call.clear();
  call(10, 10);
  EXPECT_FALSE(call.is_set());
  EXPECT_EQ(sum, 6);
}

TEST(GuardedCallTest, AnEmptyFunctionIsNotCalled) {
  GuardedCall<> call(nullptr);
  EXPECT_FALSE(call.is_set());
  call();
  call.clear();
}

TEST(GuardedCallTest, AFunctionThatClearsItsOwnCallIsNotWaitedForAndIsNotCalledAgain) {
  int calls = 0;
  GuardedCall<>* self = nullptr;
  GuardedCall<> call([&] {
    ++calls;
    self->clear();
    (*self)();
  });
  self = &call;
  call();
  call();
  EXPECT_EQ(calls, 1);
}

TEST(GuardedCallTest, AFunctionThatCallsItselfMayClearItAtAnyDepth) {
  GuardedCall<int>* self = nullptr;
  int deepest = 0;
  GuardedCall<int> call([&](int depth) {
    deepest = depth;
    depth < 3 ? (*self)(depth + 1) : self->clear();
  });
  self = &call;
  call(1);
  EXPECT_EQ(deepest, 3);
  call.clear();
}

TEST(GuardedCallTest, ACallThatThrowsIsOver) {
  GuardedCall<> call([] { throw std::runtime_error("the callback has failed"); });
  EXPECT_THROW(call(), std::runtime_error);
  call.clear();
}

/// A call that another thread is executing. The call ends only after release(), and so late that a clear()
/// that does not wait would return earlier than the call.
class GuardedCallOfAnotherThread : public testing::Test {
 protected:
  GuardedCallOfAnotherThread() { wait_for(inside_); }
  ~GuardedCallOfAnotherThread() override { caller_.join(); }

  void release() { set(released_); }

  std::function<void()> on_this_thread = [] {};
  bool ended = false;  // not atomic, because the sanitizers check that clear() orders the accesses of the
                       // threads
  const std::thread::id this_thread_ = std::this_thread::get_id();
  GuardedCall<> call{[this] {
    if (std::this_thread::get_id() == this_thread_) return on_this_thread();
    set(inside_);
    wait_for(released_);
    linger();
    ended = true;
  }};

  static void linger() {
    for (int i = 0; i < 1000; ++i) std::this_thread::yield();
  }

 private:
  std::atomic<bool> inside_{false}, released_{false};
  std::thread caller_{[this] { call(); }};
};

TEST_F(GuardedCallOfAnotherThread, IsWaitedForByWhoeverClearsIt) {
  release();
  call.clear();
  EXPECT_TRUE(ended);
}

TEST_F(GuardedCallOfAnotherThread, IsWaitedForByAFunctionThatClearsItFromWithin) {
  on_this_thread = [&] {
    release();
    call.clear();
    EXPECT_TRUE(ended);
  };
  call();
}

TEST_F(GuardedCallOfAnotherThread, IsWaitedForByAFunctionThatIsWithinAnotherCall) {
  GuardedCall<> other([&] {
    release();
    call.clear();
    EXPECT_TRUE(ended);
  });
  other();
  EXPECT_TRUE(other.is_set());
}

TEST(GuardedCallTest, TwoThatClearItFromWithinDoNotWaitForEachOther) {
  for (int round = 0; round < 200; ++round) {
    std::latch both_inside(2);
    GuardedCall<>* self = nullptr;
    GuardedCall<> call([&] {
      both_inside.arrive_and_wait();
      self->clear();
    });
    self = &call;
    std::thread other([&] { call(); });
    call();
    other.join();
  }
}

TEST(GuardedCallTest, FunctionsThatClearEachOthersCallsDoNotWaitForEachOther) {
  for (const std::size_t threads : {2U, 3U, 5U}) {
    for (int round = 0; round < 50; ++round) {
      std::latch all_inside(static_cast<std::ptrdiff_t>(threads));
      std::vector<std::unique_ptr<GuardedCall<>>> calls(threads);
      for (std::size_t i = 0; i < threads; ++i) {
        calls[i] = std::make_unique<GuardedCall<>>([&, i] {
          all_inside.arrive_and_wait();
          calls[(i + 1) % threads]->clear();
        });
      }
      std::vector<std::thread> running;
      for (const auto& call : calls) running.emplace_back([&] { (*call)(); });
      for (std::thread& thread : running) thread.join();
    }
  }
}

TEST_F(GuardedCallOfAnotherThread, IsWaitedForFromOutsideThoughOthersWaitForEachOther) {
  std::latch both_inside(2);
  std::array<std::unique_ptr<GuardedCall<>>, 2> pair;
  for (std::size_t i = 0; i < 2; ++i) {
    pair[i] = std::make_unique<GuardedCall<>>([&, i] {
      both_inside.arrive_and_wait();
      pair[1 - i]->clear();
    });
  }
  std::thread one([&] { (*pair[0])(); }), other([&] { (*pair[1])(); });
  release();
  call.clear();
  EXPECT_TRUE(ended);
  one.join();
  other.join();
}

TEST_F(GuardedCallOfAnotherThread, KeepsOneThatClearsItFromWithinAndThatOneIsWaitedForFromOutside) {
  bool ended_here = false;
  std::thread outside;
  on_this_thread = [&] {
    std::atomic<bool> clearing{false};
    outside = std::thread([&] {
      set(clearing);
      call.clear();
      EXPECT_TRUE(ended);
      EXPECT_TRUE(ended_here);
    });
    wait_for(clearing);
    release();
    call.clear();
    linger();
    ended_here = true;
  };
  call();
  outside.join();
}

TEST(GuardedCallTest, NoneOfManyThreadsIsInsideOnceItWasCleared) {
  constexpr int callers = 4;
  for (int round = 0; round < 50; ++round) {
    // The callback uses memory that is freed later, so that the sanitizers detect a use after that.
    auto used = std::make_unique<std::array<int, callers>>();
    GuardedCall<std::size_t> call([used = used.get()](std::size_t who) { ++(*used)[who]; });
    std::latch begun(callers);
    std::atomic<bool> stop{false};
    std::vector<std::thread> threads;
    for (std::size_t who = 0; who < callers; ++who) {
      threads.emplace_back([&, who] {
        call(who);
        begun.count_down();
        while (!stop) call(who);
      });
    }
    begun.wait();
    call.clear();
    for (const int calls : *used) EXPECT_GT(calls, 0);
    used.reset();
    for (int i = 0; i < 10; ++i) std::this_thread::yield();
    stop = true;
    for (std::thread& thread : threads) thread.join();
  }
}

/// Closes a gate while a call is inside.
bool close_from_another_thread() {
  CallGate gate;
  std::latch is_inside(1);
  std::thread calling([&] {
    gate.call([&] {
      is_inside.count_down();
      while (!gate.is_closed()) std::this_thread::yield();
    });
  });
  is_inside.wait();
  gate.close();
  calling.join();
  return gate.is_closed();
}

// Global objects of programs may open nodes. They may be constructed before all other objects.
[[gnu::init_priority(101)]] const struct BeforeAllOthers {
  bool has_closed = close_from_another_thread();
} before_all_others;

TEST(GuardedCallTest, CanBeClearedBeforeOtherGlobalObjectsAreConstructed) {
  EXPECT_TRUE(before_all_others.has_closed);
}

/// A thread that waits in close() when the program ends must not stop the program from ending.
void end_while_a_gate_is_being_closed() {
  ::alarm(60);
  auto& gate = *new CallGate;
  std::latch is_inside(1);
  std::thread([&] {
    gate.call([&] {
      is_inside.count_down();
      for (;;) ::pause();
    });
  }).detach();
  is_inside.wait();
  std::thread([&] { gate.close(); }).detach();
  // The second thread has closed the gate, and then waits as long as the process exists.
  while (!gate.is_closed()) std::this_thread::yield();
  std::exit(0);
}

TEST(GuardedCallDeathTest, AProgramEndsWhileAThreadWaitsForACallback) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  for (int round = 0; round < 5; ++round)
    EXPECT_EXIT(end_while_a_gate_is_being_closed(), testing::ExitedWithCode(0), "");
}

}  // namespace
}  // namespace sft::core
