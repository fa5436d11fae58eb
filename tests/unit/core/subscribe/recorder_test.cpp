// Automatic recording of requirements: fields that are read become fields that are requested.
#include "core/subscribe/recorder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <optional>
#include <thread>
#include <vector>

#include "tests/support/test_seed.h"

namespace sft::core {
namespace {

using Leaves = std::vector<std::size_t>;

Leaves leaves_of(const FieldMask& mask) { return {mask.begin(), mask.end()}; }

class RecorderTest : public ::testing::Test {
 protected:
  /// Records one sample in which all leaves are present. The given leaves are read from it.
  void sample(std::initializer_list<std::size_t> leaves) {
    RecordedSample* s = recorder->begin();
    for (const std::size_t leaf : leaves) s->log().touch(leaf, true);
    Recorder::end(s);
  }
  void samples(int n, std::initializer_list<std::size_t> leaves) {
    for (int i = 0; i < n; ++i) sample(leaves);
  }
  void reopen(const SubscriberOptions::Recording& settings) {
    recorder = Recorder::make(70, settings, [this] { ++changes; });
  }
  Leaves required() const { return leaves_of(recorder->required().mask()); }

  std::atomic<int> changes{0};
  std::shared_ptr<Recorder> recorder =
      Recorder::make(70, {.learn_samples = 2, .narrow_after_samples = 4}, [this] { ++changes; });
};

TEST_F(RecorderTest, EverythingIsRequiredUntilTheFirstSamplesWereRead) {
  EXPECT_TRUE(recorder->required().mask().is_full());
  sample({3});
  EXPECT_TRUE(recorder->required().mask().is_full());
  EXPECT_EQ(changes, 0);
}

TEST_F(RecorderTest, AfterLearningOnlyWhatWasReadIsRequired) {
  sample({3});
  sample({69});
  EXPECT_EQ(required(), (Leaves{3, 69}));
  EXPECT_EQ(changes, 1);
}

TEST_F(RecorderTest, AnAccessToAnAbsentLeafWidensAtOnceAndOnlyOnce) {
  samples(2, {3});
  RecordedSample* s = recorder->begin();
  s->log().touch(5, false);
  EXPECT_EQ(required(), (Leaves{3, 5}));
  EXPECT_EQ(changes, 2);
  s->log().touch(5, false);
  Recorder::end(s);
  EXPECT_EQ(changes, 2);
}

TEST_F(RecorderTest, AnAccessToALeafThatIsThereUnaskedWidensAtOnceToo) {
  samples(2, {3});
  RecordedSample* s = recorder->begin();
  s->log().touch(5, true);
  EXPECT_EQ(required(), (Leaves{3, 5}));
  Recorder::end(s);
  EXPECT_EQ(changes, 2);
}

TEST_F(RecorderTest, ALeafNotReadForLongIsNoLongerRequired) {
  sample({3, 4});
  samples(3, {3});
  EXPECT_EQ(required(), (Leaves{3, 4}));
  sample({3});
  EXPECT_EQ(required(), (Leaves{3}));
}

TEST_F(RecorderTest, ALeafReadJustOftenEnoughIsNeverGivenUp) {
  samples(2, {3, 4});
  changes = 0;
  for (int i = 0; i < 100; ++i) {
    samples(3, {3});
    sample({3, 4});
  }
  EXPECT_EQ(changes, 0);
}

TEST_F(RecorderTest, NarrowAfterZeroSamplesMeansNever) {
  reopen({.learn_samples = 1, .narrow_after_samples = 0});
  sample({3});
  samples(1000, {});
  EXPECT_EQ(required(), (Leaves{3}));
}

TEST_F(RecorderTest, SettingsThatMakeNoSenseAreRefused) {
  EXPECT_TRUE(Recorder::check({}));
  EXPECT_TRUE(Recorder::check({.narrow_after_samples = 0}));
  const Result<void> refused = Recorder::check({.learn_samples = 0});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Errc::invalid_argument);
}

TEST_F(RecorderTest, SamplesThatNobodyReadNarrowToNothing) {
  samples(2, {});
  EXPECT_TRUE(recorder->required().mask().empty());
}

TEST_F(RecorderTest, EveryLeafCountsOncePerSampleHoweverOftenItIsRead) {
  samples(3, {});
  RecordedSample* s = recorder->begin();
  for (int i = 0; i < 10; ++i) s->log().touch(65, true);
  EXPECT_EQ(recorder->use().leaves[65].samples, 0U) << "it has not been released";
  Recorder::end(s);
  EXPECT_EQ(recorder->use().samples, 4U);
  EXPECT_EQ(recorder->use().leaves[65].samples, 1U);
  EXPECT_EQ(recorder->use().leaves[65].last_sample, 4U);
  EXPECT_EQ(recorder->use().leaves[64].last_sample, 0U);
}

TEST_F(RecorderTest, ReadsCountWhenTheirSampleIsReleasedInWhateverOrder) {
  samples(2, {3});
  RecordedSample* kept = recorder->begin();
  kept->log().touch(5, true);
  samples(6, {3});
  EXPECT_EQ(required(), (Leaves{3}));
  Recorder::end(kept);
  EXPECT_EQ(required(), (Leaves{3, 5}));
  EXPECT_EQ(recorder->use().leaves[5].last_sample, 9U);
}

TEST_F(RecorderTest, WhoeverIsToldMayAskForWhatChanged) {
  Leaves reported;
  recorder = Recorder::make(70, {.learn_samples = 1}, [&] { reported = required(); });
  sample({7});
  EXPECT_EQ(reported, (Leaves{7}));
  RecordedSample* s = recorder->begin();
  s->log().touch(8, false);
  EXPECT_EQ(reported, (Leaves{7, 8}));
  Recorder::end(s);
}

TEST_F(RecorderTest, ASampleMayOutliveItsSubscriber) {
  RecordedSample* s = recorder->begin();
  recorder->detach();
  recorder.reset();
  std::thread([s] {
    s->log().touch(1, true);
    Recorder::end(s);
  }).join();
  EXPECT_EQ(changes, 0);
}

// ---- threads ----

TEST_F(RecorderTest, SamplesMayBeReadAndReleasedByManyThreads) {
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < 4; ++t) {
    threads.emplace_back([this, t] {
      for (int i = 0; i < 500; ++i) sample({t, 20});
    });
  }
  for (auto& t : threads) t.join();
  EXPECT_EQ(recorder->use().leaves[20].samples, 2000U);
  EXPECT_TRUE(recorder->required().mask().contains(20));
}

TEST_F(RecorderTest, ThreadsThatReadOneSampleCountItOnceForEachLeaf) {
  samples(2, {});
  for (int round = 1; round <= 200; ++round) {
    RecordedSample* s = recorder->begin();
    std::vector<std::thread> threads;
    for (std::size_t t = 0; t < 3; ++t) {
      threads.emplace_back([s, t] {
        for (const std::size_t leaf : {std::size_t{0}, std::size_t{64}, 1 + t})
          s->log().touch(leaf, leaf != 0);
      });
    }
    for (auto& t : threads) t.join();
    Recorder::end(s);
    ASSERT_EQ(recorder->use().leaves[64].samples, static_cast<std::uint64_t>(round));
    ASSERT_EQ(required(), (Leaves{0, 1, 2, 3, 64}));
  }
  EXPECT_EQ(changes, 1 + 5);
}

TEST_F(RecorderTest, OnceDetachedNobodyIsTold) {
  for (int round = 0; round < 200; ++round) {
    auto gone = std::make_unique<std::atomic<bool>>(false);
    recorder = Recorder::make(70, {.learn_samples = 1, .narrow_after_samples = 1},
                              [reported = gone.get()] { EXPECT_FALSE(reported->load()); });
    std::atomic<int> started{0};
    const auto read = [&, recording = recorder](std::size_t leaf) {
      for (int i = 0; i < 20; ++i) {
        RecordedSample* s = recording->begin();
        s->log().touch(leaf + static_cast<std::size_t>(i) % 2, false);
        Recorder::end(s);
        ++started;
      }
    };
    std::thread a(read, 1), b(read, 10);
    while (started == 0) std::this_thread::yield();
    recorder->detach();
    gone->store(true);
    gone.reset();  // lets the sanitizers notice a later notification
    a.join();
    b.join();
  }
}

// ---- any pattern of reads ----

/// The rules of the recorder in their simplest form, which computes all leaves for each sample.
class Promise {
 public:
  Promise(std::size_t leaves, const SubscriberOptions::Recording& settings)
      : settings_(settings), needed_since_(leaves, 0), required_(FieldMask::full(leaves)) {}

  void read(std::size_t leaf) {
    if (!required_.contains(leaf)) need(leaf, samples_ + 1);
  }
  void release(const FieldMask& read) {
    ++samples_;
    for (const std::size_t leaf : read) need(leaf, samples_);
    if (samples_ < settings_.learn_samples) return;
    for (std::size_t leaf = 0; leaf < needed_since_.size(); ++leaf) {
      const std::uint64_t since = needed_since_[leaf];
      if (since == 0 || samples_ >= since + settings_.narrow_after_samples) required_.erase(leaf);
    }
  }
  const FieldMask& required() const { return required_; }
  std::uint64_t samples() const { return samples_; }

 private:
  void need(std::size_t leaf, std::uint64_t sample) {
    required_.insert(leaf);
    needed_since_[leaf] = std::max(needed_since_[leaf], sample);
  }

  const SubscriberOptions::Recording settings_;
  std::vector<std::uint64_t> needed_since_;
  FieldMask required_;
  std::uint64_t samples_ = 0;
};

class AnyReads : public test::RandomTest {
 protected:
  struct Out {
    RecordedSample* sample;
    FieldMask read;
  };

  std::size_t below(std::size_t n) { return static_cast<std::size_t>(random() % n); }

  void open(std::size_t leaves, const SubscriberOptions::Recording& settings) {
    reported = changes = 0;
    recorder = Recorder::make(leaves, settings, [this] { ++reported; });
    promise.emplace(leaves, settings);
  }
  void take() { out.push_back({recorder->begin(), FieldMask(promise->required().leaves())}); }
  void read(std::size_t leaf) {
    Out& one = out[below(out.size())];
    one.sample->log().touch(leaf, leaf % 3 != 0);
    if (one.read.contains(leaf)) return;
    one.read.insert(leaf);
    follow([&] { promise->read(leaf); });
  }
  FieldMask release() {
    const auto one = out.begin() + static_cast<std::ptrdiff_t>(below(out.size()));
    const FieldMask reads = one->read;
    Recorder::end(one->sample);
    out.erase(one);
    follow([&] { promise->release(reads); });
    return reads;
  }
  template <class Event>
  void follow(Event event) {
    const FieldMask before = promise->required();
    event();
    if (promise->required() != before) ++changes;
  }

  std::shared_ptr<Recorder> recorder;
  std::optional<Promise> promise;
  std::vector<Out> out;
  int reported = 0, changes = 0;
};

TEST_F(AnyReads, AreFollowedAsPromisedAndEveryChangeIsToldOnce) {
  for (int round = 0; round < 300; ++round) {
    const std::size_t leaves = 1 + below(150);
    open(leaves, {.learn_samples = static_cast<std::uint32_t>(1 + below(5)),
                  .narrow_after_samples = static_cast<std::uint32_t>(1 + below(20))});
    for (int step = 0; step < 300; ++step) {
      const std::size_t what = below(10);
      if (out.empty() || (what == 0 && out.size() < 5)) {
        take();
      } else if (what < 4) {
        release();
      } else {
        const std::size_t favourites = 1 + below(leaves);
        read(below(favourites));
      }
      ASSERT_EQ(leaves_of(recorder->required().mask()), leaves_of(promise->required())) << "step " << step;
      ASSERT_EQ(reported, changes) << "step " << step;
    }
    while (!out.empty()) release();
  }
}

TEST_F(AnyReads, NeverFlap) {
  for (int round = 0; round < 100; ++round) {
    const std::size_t leaves = 1 + below(100);
    const std::size_t hang_timeout = 1 + below(20);
    open(leaves, {.learn_samples = 1, .narrow_after_samples = static_cast<std::uint32_t>(hang_timeout)});
    std::vector<std::size_t> periods;  // the period, in samples, in which each leaf is read
    for (std::size_t leaf = 0; leaf < leaves; ++leaf) periods.push_back(1 + below(3 * hang_timeout));
    std::vector<std::uint64_t> given_up_at(leaves, 0), read_at(leaves, 0);
    int times_given_up = 0;
    for (std::uint64_t n = 1; n <= 300; ++n) {
      const FieldMask before = recorder->required().mask();
      RecordedSample* s = recorder->begin();
      for (std::size_t leaf = 0; leaf < leaves; ++leaf) {
        if (n % periods[leaf] != 0 && n != 1) continue;
        s->log().touch(leaf, before.contains(leaf));
        read_at[leaf] = n;
      }
      Recorder::end(s);
      for (const std::size_t leaf : before - recorder->required().mask()) {
        ASSERT_GT(periods[leaf], hang_timeout) << "it is read often enough";
        ASSERT_EQ(n, read_at[leaf] + hang_timeout);
        ASSERT_TRUE(given_up_at[leaf] == 0 || n > given_up_at[leaf] + hang_timeout);
        given_up_at[leaf] = n;
        ++times_given_up;
      }
      for (std::size_t leaf = 0; leaf < leaves; ++leaf)
        ASSERT_TRUE(n >= read_at[leaf] + hang_timeout || recorder->required().mask().contains(leaf)) << leaf;
    }
    ASSERT_LE(reported, 2 * times_given_up + 1) << "what was never given up does not come back";
  }
}

}  // namespace
}  // namespace sft::core
