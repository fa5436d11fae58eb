// Threads of a program that wait for subscribers of one node. Even if one thread always has a next sample,
// no other thread waits for ever.
#include <gtest/gtest.h>
#include <poll.h>

#include <sft/sft.h>
#include <atomic>
#include <stop_token>
#include <thread>

#include "core/sync/mutex.h"
#include "tests/system/fixture.h"

namespace sft::test {
namespace {

class FairWaits : public PubSubTest {
 protected:
  static constexpr std::uint32_t presses = 80;

  /// Starts a thread that takes samples of a topic. Whatever the speed of the machine, there is always a
  /// next sample, because the thread publishes a sample for each sample that it takes.
  std::jthread take_images_without_end(Subscriber<PointCloud2>& camera) {
    for (int i = 0; i < 4; ++i) images_.publish(cloud(0));
    return std::jthread([this, &camera](const std::stop_token& ends) {
      while (!ends.stop_requested() && camera.wait(hang_timeout)) {
        while (!ends.stop_requested() && camera.take()) images_.publish(cloud(++taken_));
      }
    });
  }
  /// Publishes the stop `number` once further images have been taken.
  void press(std::uint32_t number) {
    const std::uint32_t before = taken_;
    ASSERT_TRUE(eventually([&] { return taken_ > before; })) << "images come";
    stops_.publish(cloud(number));
  }
  /// Called on the thread of the test and on the thread of the callbacks.
  void publish_next() {
    const core::Lock lock(publishing_);
    images_.publish(cloud(++taken_));
  }
  static std::uint32_t taken_from(Subscriber<PointCloud2>& stop) {
    const auto sample = stop.take();
    return sample ? sample->height() : 0;
  }

  Node source_ = open("source");
  Node app_ = open("app");
  Publisher<PointCloud2> images_ = source_.publisher<PointCloud2>("camera").value();
  Publisher<PointCloud2> stops_ = source_.publisher<PointCloud2>("stop", {.reliability = reliable}).value();
  std::atomic<std::uint32_t> taken_{0};
  core::Mutex publishing_;
};

INSTANTIATE_TEST_SUITE_P(Ways, FairWaits, testing::Values(Way::shm, Way::udp, Way::udp_sockets), way_name);

TEST_P(FairWaits, AThreadIsNotStarvedByAnotherOneThatAlwaysHasANextSample) {
  auto camera = app_.subscriber<PointCloud2>("camera", {.depth = 8}).value();
  auto stop = app_.subscriber<PointCloud2>("stop", {.reliability = reliable}).value();
  expect_served(images_, 1);
  expect_served(stops_, 1);
  const std::jthread taking = take_images_without_end(camera);
  for (std::uint32_t i = 1; i <= presses; ++i) {
    press(i);
    ASSERT_TRUE(stop.wait(hang_timeout)) << i;
    EXPECT_EQ(taken_from(stop), i);
  }
}

TEST_P(FairWaits, AFileDescriptorIsNotStarvedByAnotherOneThatIsAlwaysReadable) {
  auto camera = app_.subscriber<PointCloud2>("camera", {.depth = 8, .pollable = true}).value();
  auto stop = app_.subscriber<PointCloud2>("stop", {.reliability = reliable, .pollable = true}).value();
  expect_served(images_, 1);
  expect_served(stops_, 1);
  const std::jthread taking = take_images_without_end(camera);
  for (std::uint32_t i = 1; i <= presses; ++i) {
    press(i);
    pollfd readable{.fd = stop.file_descriptor(), .events = POLLIN, .revents = 0};
    ASSERT_TRUE(eventually([&] { return poll(&readable, 1, 100) == 1; })) << i;
    EXPECT_EQ(taken_from(stop), i);
  }
}

/// The thread of the callbacks is that of the dispatcher, or the thread that receives.
TEST_P(FairWaits, ACallbackIsNotStarvedByAThreadThatAlwaysHasANextSample) {
  auto camera = app_.subscriber<PointCloud2>("camera", {.depth = 8}).value();
  std::atomic<std::uint32_t> pressed{0};
  const auto stop =
      app_.subscriber<PointCloud2>("stop", [&](const auto& sample) { pressed = sample->height(); },
                                   {.reliability = reliable})
          .value();
  expect_served(images_, 1);
  expect_served(stops_, 1);
  const std::jthread taking = take_images_without_end(camera);
  for (std::uint32_t i = 1; i <= presses; ++i) {
    press(i);
    ASSERT_TRUE(eventually([&] { return pressed == i; })) << i;
  }
}

TEST_P(FairWaits, AThreadIsNotStarvedByCallbacksThatAlwaysHaveANextSample) {
  const auto camera =
      app_.subscriber<PointCloud2>("camera", [this](const auto&) { publish_next(); }, {.depth = 8}).value();
  auto stop = app_.subscriber<PointCloud2>("stop", {.reliability = reliable}).value();
  expect_served(images_, 1);
  expect_served(stops_, 1);
  for (int i = 0; i < 4; ++i) publish_next();
  for (std::uint32_t i = 1; i <= presses; ++i) {
    press(i);
    ASSERT_TRUE(stop.wait(hang_timeout)) << i;
    EXPECT_EQ(taken_from(stop), i);
  }
}

/// One thread waits for several subscribers in turns, as a program without callbacks does.
TEST_P(FairWaits, ASubscriberIsNotStarvedByAnotherOneOfTheSameThread) {
  auto camera = app_.subscriber<PointCloud2>("camera", {.depth = 8}).value();
  auto stop = app_.subscriber<PointCloud2>("stop", {.reliability = reliable}).value();
  expect_served(images_, 1);
  expect_served(stops_, 1);
  for (int i = 0; i < 4; ++i) images_.publish(cloud(0));
  for (std::uint32_t i = 1; i <= presses; ++i) {
    stops_.publish(cloud(i));
    ASSERT_TRUE(eventually([&] {
      if (camera.wait(1ms) && camera.take()) images_.publish(cloud(++taken_));
      return stop.wait(0ns) && taken_from(stop) == i;
    })) << i;
    EXPECT_TRUE(eventually([&] {
      images_.publish(cloud(++taken_));
      return camera.wait(1ms);
    })) << "images come";
  }
}

}  // namespace
}  // namespace sft::test
