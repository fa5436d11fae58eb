// Threads of a program that wait for subscribers of one node. Even if one thread always has a next sample,
// no other thread waits for ever.
#include <gtest/gtest.h>
#include <poll.h>

#include <sft/sft.h>
#include <atomic>
#include <stop_token>
#include <thread>

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
  static std::uint32_t taken_from(Subscriber<PointCloud2>& stop) {
    const auto sample = stop.take();
    return sample ? sample->height() : 0;
  }

  Node source_ = open("source");
  Node app_ = open("app");
  Publisher<PointCloud2> images_ = source_.publisher<PointCloud2>("camera").value();
  Publisher<PointCloud2> stops_ = source_.publisher<PointCloud2>("stop", {.reliability = reliable}).value();
  std::atomic<std::uint32_t> taken_{0};
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

}  // namespace
}  // namespace sft::test
