// Callbacks of one node share threads. Even if one callback always has a next sample, no other callback
// waits for ever. The log names a callback that waits long.
#include <gtest/gtest.h>

#include <sft/sft.h>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/sync/mutex.h"
#include "tests/system/fixture.h"

namespace sft::test {
namespace {

using Clock = std::chrono::steady_clock;

void work_for(Clock::duration time) {
  for (const auto end = Clock::now() + time; Clock::now() < end;) {
  }
}

class FairCallbacks : public PubSubTest {
 protected:
  void SetUp() override { camera_.emplace(source().publisher<PointCloud2>("camera").value()); }
  /// Returns the node of the publishers.
  virtual Node& source() { return source_; }

  /// Opens subscribers that always have a next sample, whatever the speed of the machine: each callback
  /// publishes a sample at its end.
  void open_busy(std::size_t subscribers, Clock::duration work) {
    for (std::size_t i = 0; i < subscribers; ++i) {
      busy_.push_back(app_.subscriber<PointCloud2>("camera",
                                                   [this, work](const auto&) {
                                                     work_for(work);
                                                     publish_next();
                                                   })
                          .value());
    }
    expect_served(*camera_, subscribers);
    for (int i = 0; i < 4; ++i) publish_next();
    ASSERT_TRUE(eventually([&] { return images_ > 10; }));
  }
  /// Called on the thread of the test and on the thread of the callbacks.
  void publish_next() {
    const core::Lock lock(publishing_);
    camera_->publish(cloud(++images_));
  }
  /// Returns the number of samples, out of 80, for which the callback was not called, and prints it.
  std::size_t starved(Clock::duration work) {
    const std::size_t starved = starved_beside_busy(work);
    std::printf("starved callbacks: %zu of 80, %s\n", starved,
                testing::UnitTest::GetInstance()->current_test_info()->name());
    return starved;
  }
  std::size_t starved_beside_busy(Clock::duration work) {
    auto halt = source().publisher<PointCloud2>("stop", {.reliability = reliable}).value();
    std::atomic<std::size_t> stops{0};
    const auto stop = app_.subscriber<PointCloud2>("stop",
                                                   [&](const auto&) {
                                                     work_for(work);
                                                     ++stops;
                                                   },
                                                   {.reliability = reliable})
                          .value();
    expect_served(halt, 1);
    for (std::size_t i = 1; i <= 80; ++i) {
      halt.publish(cloud(static_cast<std::uint32_t>(i)));
      if (!eventually([&] { return stops == i; })) return 80 - stops;
    }
    return 0;
  }

  Node source_ = open("source");
  Node app_ = open("app");
  core::Mutex publishing_;
  std::optional<Publisher<PointCloud2>> camera_;
  std::atomic<std::uint32_t> images_{0};
  std::vector<Subscriber<PointCloud2>> busy_;
};

INSTANTIATE_TEST_SUITE_P(Ways, FairCallbacks, ::testing::Values(Way::shm, Way::udp, Way::udp_sockets),
                         way_name);

TEST_P(FairCallbacks, NoneIsStarvedByQuickOnesThatAlwaysHaveANextSample) {
  open_busy(1, 0us);
  EXPECT_EQ(starved(0us), 0U);
}

TEST_P(FairCallbacks, NoneIsStarvedByOneThatIsSlowerThanItsTopic) {
  open_busy(1, 5ms);
  EXPECT_EQ(starved(0us), 0U);
}

TEST_P(FairCallbacks, NoneIsStarvedWhereAllAreSlow) {
  open_busy(1, 5ms);
  EXPECT_EQ(starved(5ms), 0U);
}

TEST_P(FairCallbacks, NoneIsStarvedByManyThatAlwaysHaveANextSample) {
  open_busy(16, 300us);
  EXPECT_EQ(starved(300us), 0U);
}

class FairCallbacksOfOneNode : public FairCallbacks {
 protected:
  Node& source() override { return app_; }
};
INSTANTIATE_TEST_SUITE_P(Ways, FairCallbacksOfOneNode,
                         ::testing::Values(Way::shm, Way::udp, Way::udp_sockets), way_name);

TEST_P(FairCallbacksOfOneNode, NoneIsStarvedWherePublishersAndSubscribersShareIt) {
  open_busy(1, 5ms);
  EXPECT_EQ(starved(0us), 0U);
}

/// Keeps the lines of warnings.
class Log {
 public:
  NodeOptions::LogSink sink() {
    return [this](LogLevel level, std::string_view line) {
      const core::Lock lock(mutex_);
      if (level >= LogLevel::warning) lines_.emplace_back(line);
    };
  }
  bool has(std::string_view part) {
    const core::Lock lock(mutex_);
    return std::ranges::any_of(lines_, [&](const std::string& line) { return line.find(part) != line.npos; });
  }

 private:
  core::Mutex mutex_;
  std::vector<std::string> lines_ SFT_GUARDED_BY(mutex_);
};

class LongCallback : public PubSubTest {
 protected:
  void SetUp() override {
    NodeOptions options = node_options(GetParam(), "app");
    options.log = log_.sink();
    app_.emplace(Node::open(options).value());
    publisher_.emplace(source_.publisher<PointCloud2>("camera").value());
    subscriber_.emplace(app_->subscriber<PointCloud2>("camera",
                                                      [this](const auto&) {
                                                        ++calls_;
                                                        EXPECT_TRUE(
                                                            eventually([&] { return goes_on_.load(); }));
                                                      })
                            .value());
    expect_served(*publisher_, 1);
    publisher_->publish(cloud(1));
    ASSERT_TRUE(eventually([&] { return calls_ == 1; }));
  }
  void TearDown() override { goes_on_ = true; }

  Log log_;
  Node source_ = open("source");
  std::atomic<bool> goes_on_{false};
  std::atomic<int> calls_{0};
  std::optional<Node> app_;
  std::optional<Publisher<PointCloud2>> publisher_;
  std::optional<Subscriber<PointCloud2>> subscriber_;
};

class LongCallbackInSharedMemory : public LongCallback {};
INSTANTIATE_TEST_SUITE_P(Ways, LongCallbackInSharedMemory, ::testing::Values(Way::shm), way_name);

TEST_P(LongCallbackInSharedMemory, IsNamedWithTheSubscriberThatWaitsForItWhichCountsThat) {
  auto halt = source_.publisher<PointCloud2>("stop").value();
  std::atomic<int> stops{0};
  const auto stop = app_->subscriber<PointCloud2>("stop", [&](const auto&) { ++stops; }).value();
  expect_served(halt, 1);
  EXPECT_EQ(stop.status().long_waits, 0U);
  halt.publish(cloud(1));
  EXPECT_TRUE(eventually([&] { return stop.status().long_waits == 1; }));
  EXPECT_TRUE(eventually([&] {
    return log_.has("topic 'stop': a sample has waited for its callback for ") &&
           log_.has(", at present that of topic 'camera'; open a node of its own for a long callback");
  }));
  EXPECT_EQ(subscriber_->status().long_waits, 0U) << "no sample of it waits for another callback";
  goes_on_ = true;
  EXPECT_TRUE(eventually([&] { return stops == 1; }));
  EXPECT_EQ(stop.status().long_waits, 1U);
}

class LongCallbackByUdp : public LongCallback {};
INSTANTIATE_TEST_SUITE_P(Ways, LongCallbackByUdp, ::testing::Values(Way::udp, Way::udp_sockets), way_name);

TEST_P(LongCallbackByUdp, IsNamedIfItHoldsUpTheThreadThatReceives) {
  EXPECT_TRUE(eventually([&] { return log_.has("topic 'camera': its callback has run for "); }));
  EXPECT_TRUE(log_.has(" on the thread that receives by UDP, which receives nothing meanwhile"));
  EXPECT_EQ(subscriber_->status().long_waits, 0U) << "no sample of it waits for another callback";
}

}  // namespace
}  // namespace sft::test
