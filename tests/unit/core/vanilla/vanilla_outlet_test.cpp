// The queue of samples for DDS readers, from which a thread writes them, has a limited length.
#include "core/vanilla/vanilla_outlet.h"

#include <gmock/gmock.h>

#include <future>

#include "core/seam/buffer_pool.h"
#include "tests/support/eventually.h"

namespace sft::core {
namespace {

using testing::ElementsAre;
using testing::ElementsAreArray;

class VanillaOutletTest : public testing::Test {
 protected:
  ~VanillaOutletTest() override { let_write(); }

  SampleHandle sample(std::uint64_t sequence, std::size_t bytes = 100) {
    SampleHandle made = pool->take(bytes);
    made->sequence = sequence;
    return made;
  }
  void send(std::uint64_t sequence, std::size_t bytes = 100) { outlet.send(sample(sequence, bytes)); }
  void start() { ASSERT_TRUE(outlet.start("test")); }
  /// Starts the thread, and returns while the thread writes the first sample. That write ends only after
  /// let_write().
  void start_and_write(std::uint64_t sequence) {
    is_held_up = true;
    start();
    send(sequence);
    begun.get_future().wait();
  }
  void let_write() {
    if (std::exchange(is_held_up, false)) may_go_on.set_value();
  }
  /// Waits until `count` samples were written, and returns their sequences.
  std::vector<std::uint64_t> written(std::size_t count) {
    EXPECT_TRUE(test::eventually([&] {
      const Lock lock(mutex);
      return sequences.size() >= count;
    }));
    const Lock lock(mutex);
    return sequences;
  }

  const std::shared_ptr<BufferPool> pool = BufferPool::make(64 << 20);
  bool is_held_up = false;
  std::promise<void> begun, may_go_on;
  int written_before = 0;  ///< used by the outlet's thread
  Mutex mutex;
  std::vector<std::uint64_t> sequences SFT_GUARDED_BY(mutex);
  VanillaOutlet outlet{[this](const SampleHandle& one) {
                         const bool is_first = written_before++ == 0;
                         if (is_first && is_held_up) {
                           begun.set_value();
                           may_go_on.get_future().wait();
                         }
                         const Lock lock(mutex);
                         sequences.push_back(one->sequence);
                         return true;
                       },
                       5};
};

TEST_F(VanillaOutletTest, WhatIsRetainedIsWrittenFirstAndNothingTwice) {
  send(3);  // sent before the thread begins, and retained as well
  send(4);
  outlet.begin_with({sample(1), sample(2), sample(3)});
  start();
  EXPECT_THAT(written(4), ElementsAre(1, 2, 3, 4));
}

TEST_F(VanillaOutletTest, SmallSamplesWaitWhileOneIsWrittenAndTheOldestAreLeftOut) {
  start_and_write(1);
  constexpr std::size_t most = VanillaOutlet::waiting_max;
  for (std::uint64_t sequence = 2; sequence < most + 4; ++sequence) send(sequence);
  EXPECT_EQ(outlet.left_out(), 2U);
  let_write();
  std::vector<std::uint64_t> expected{1};
  for (std::uint64_t sequence = 4; sequence < most + 4; ++sequence) expected.push_back(sequence);
  EXPECT_THAT(written(most + 1), ElementsAreArray(expected));
}

TEST_F(VanillaOutletTest, OfLargeSamplesAsManyWaitAsThePublisherRetains) {
  start_and_write(1);
  for (std::uint64_t sequence = 2; sequence < 10; ++sequence) send(sequence, 1'000'000);
  let_write();
  EXPECT_THAT(written(6), ElementsAre(1, 5, 6, 7, 8, 9));
}

TEST_F(VanillaOutletTest, AsManySmallSamplesWaitAsEverOnceLargeOnesHaveGone) {
  for (std::uint64_t sequence = 1; sequence <= 10; ++sequence) send(sequence, 1'000'000);
  EXPECT_EQ(outlet.left_out(), 5U);
  constexpr std::size_t most = VanillaOutlet::waiting_max;
  for (std::uint64_t sequence = 11; sequence < 11 + most; ++sequence) send(sequence);
  EXPECT_EQ(outlet.left_out(), 10U) << "only the large ones";
}

TEST_F(VanillaOutletTest, CountsEachSampleThatCouldNotBeWritten) {
  VanillaOutlet failing([](const SampleHandle& one) { return one->sequence % 2 == 0; }, 5);
  for (std::uint64_t sequence = 1; sequence <= 5; ++sequence) failing.send(sample(sequence));
  ASSERT_TRUE(failing.start("test"));
  EXPECT_TRUE(test::eventually([&] { return failing.left_out() == 3; })) << failing.left_out();
  failing.close();
  EXPECT_EQ(failing.left_out(), 3U);
}

TEST_F(VanillaOutletTest, ThatIsClosedHoldsNothingAndTakesNothing) {
  send(1);
  outlet.close();
  const SampleHandle late = sample(2);
  outlet.send(late);
  EXPECT_TRUE(late.is_only());
}

}  // namespace
}  // namespace sft::core
