// A limited number of calls are queued for the callback thread, and the sources of the calls take turns.
#include "core/report/callback_thread.h"

#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <string>

#include "tests/support/eventually.h"

namespace sft::core {
namespace {

class CallbackThreadTest : public testing::Test {
 protected:
  void SetUp() override { ASSERT_TRUE(thread_.start()); }
  /// Posts a call of the source that does not return until release() is called, and waits until it has
  /// begun.
  void hold(const char& source) {
    std::promise<void> begun;
    may_return_ = {};
    thread_.post(&source, [&begun, returns = may_return_.get_future().share()] {
      begun.set_value();
      returns.wait();
    });
    begun.get_future().wait();
  }
  void release() { may_return_.set_value(); }
  void post(const char& source) {
    thread_.post(&source, [&] {
      calls_ += source;
      ++called_;
    });
  }
  /// Runs the remaining calls. Returns the names of the sources of all calls, in the order of the calls.
  std::string all_calls() {
    thread_.stop();
    return calls_;
  }

  static constexpr std::uint64_t waiting_max = 10'000;
  const char a_ = 'a', b_ = 'b', c_ = 'c';
  std::atomic<std::uint64_t> called_{0};
  CallbackThread thread_{{"test", {}}};

 private:
  std::promise<void> may_return_;
  std::string calls_;
};

TEST_F(CallbackThreadTest, LeavesOutTheCallsBeyondTenThousandEachTimeThatACallbackDoesNotReturn) {
  constexpr std::uint64_t too_many = 7;
  for (std::uint64_t round = 1; round <= 3; ++round) {
    hold(a_);
    for (std::uint64_t i = 0; i < waiting_max + too_many; ++i) post(a_);
    EXPECT_EQ(thread_.take_left_out(), 0U) << "no callback can report it now";
    release();
    ASSERT_TRUE(test::eventually([&] { return called_ == round * waiting_max; })) << called_;
    EXPECT_EQ(thread_.take_left_out(), too_many);
    EXPECT_EQ(thread_.take_left_out(), 0U) << "the number is reported once";
  }
}

TEST_F(CallbackThreadTest, LeavesOutNoCallOfASourceBecauseAnotherOneHasTooMany) {
  hold(a_);
  for (std::uint64_t i = 0; i < waiting_max + 1; ++i) post(a_);
  post(b_);
  release();
  EXPECT_EQ(all_calls().substr(0, 3), "aba");
}

TEST_F(CallbackThreadTest, CallsSourcesInTurnsAndTheCallsOfEachInTheirOrder) {
  hold(a_);
  for (int i = 0; i < 5; ++i) post(a_);
  for (int i = 0; i < 2; ++i) post(b_);
  post(c_);
  release();
  EXPECT_EQ(all_calls(), "abcabaaa");
}

}  // namespace
}  // namespace sft::core
