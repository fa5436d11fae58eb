// Automatic requirement recording: what is read becomes what is asked for.
#include "core/recorder.h"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

namespace sft::core {
namespace {

class RecorderTest : public ::testing::Test {
 protected:
  /// One sample of which these leaves are read, all of them present.
  void sample(std::initializer_list<std::size_t> leaves) {
    RecordedSample* s = recorder->begin();
    for (const std::size_t leaf : leaves) s->log().touch(leaf, true);
    Recorder::end(s);
  }
  std::vector<std::size_t> required() const {
    std::vector<std::size_t> leaves;
    const FieldMask mask = recorder->required();
    for (std::size_t i = 0; i < mask.leaves(); ++i) {
      if (mask.contains(i)) leaves.push_back(i);
    }
    return leaves;
  }

  std::atomic<int> changes{0};
  std::shared_ptr<Recorder> recorder =
      Recorder::make(70, {.learn_samples = 2, .narrow_after_samples = 4}, [this] { ++changes; });
};

using Leaves = std::vector<std::size_t>;

TEST_F(RecorderTest, EverythingIsRequiredUntilTheFirstSamplesWereRead) {
  EXPECT_TRUE(recorder->required().is_full());
  sample({3});
  EXPECT_TRUE(recorder->required().is_full());
  EXPECT_EQ(changes, 0);
}

TEST_F(RecorderTest, AfterLearningOnlyWhatWasReadIsRequired) {
  sample({3});
  sample({69});
  EXPECT_EQ(required(), (Leaves{3, 69}));
  EXPECT_EQ(changes, 1);
}

TEST_F(RecorderTest, AnAccessToAnAbsentLeafWidensAtOnceAndOnlyOnce) {
  sample({3});
  sample({3});
  RecordedSample* s = recorder->begin();
  s->log().touch(5, false);
  EXPECT_EQ(required(), (Leaves{3, 5}));
  EXPECT_EQ(changes, 2);
  s->log().touch(5, false);
  Recorder::end(s);
  EXPECT_EQ(changes, 2);
}

TEST_F(RecorderTest, ALeafNotReadForLongIsNoLongerRequired) {
  sample({3, 4});
  sample({3});
  for (int i = 0; i < 2; ++i) sample({3});
  EXPECT_EQ(required(), (Leaves{3, 4}));
  sample({3});
  EXPECT_EQ(required(), (Leaves{3}));
}

TEST_F(RecorderTest, SamplesThatNobodyReadNarrowToNothing) {
  sample({});
  sample({});
  EXPECT_TRUE(recorder->required().empty());
}

TEST_F(RecorderTest, EveryLeafCountsOncePerSampleHoweverOftenItIsRead) {
  RecordedSample* s = recorder->begin();
  for (int i = 0; i < 10; ++i) s->log().touch(65, true);
  Recorder::end(s);
  EXPECT_EQ(recorder->counts()[65], 1U);
}

TEST_F(RecorderTest, SamplesMayBeReadAndReleasedByManyThreads) {
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < 4; ++t) {
    threads.emplace_back([this, t] {
      for (int i = 0; i < 500; ++i) sample({t, 20});
    });
  }
  for (auto& t : threads) t.join();
  EXPECT_EQ(recorder->counts()[20], 2000U);
  EXPECT_TRUE(recorder->required().contains(20));
}

TEST_F(RecorderTest, ASampleMayOutliveItsSubscriber) {
  RecordedSample* s = recorder->begin();
  recorder.reset();
  s->log().touch(1, true);
  Recorder::end(s);
}

}  // namespace
}  // namespace sft::core
