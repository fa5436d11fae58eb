// Topics of one node share its sending thread, its receiving thread and its agent. Even if one topic is
// published without a pause, no other topic and no other reader of the topic waits for ever.
#include <gtest/gtest.h>

#include <sft/sft.h>
#include <atomic>
#include <stop_token>
#include <thread>

#include "tests/system/fixture.h"

namespace sft::test {
namespace {

class FairTopics : public PubSubTest {
 protected:
  static constexpr std::uint32_t presses = 40;
  static constexpr std::size_t large = 400'000;  // bytes, more than the publisher's thread sends itself

  /// The queues of the endless topic overflow, which is logged.
  void SetUp() override { warnings_expected = true; }

  /// Publishes large samples until the result is destroyed.
  std::jthread publish_without_a_pause() {
    return std::jthread([this](const std::stop_token& ends) {
      for (const PointCloud2 message = cloud(1, large); !ends.stop_requested(); ++published_)
        clouds_.publish(message);
    });
  }
  /// Publishes samples of `bytes` one after the other on a topic that comes now, while the other topic goes
  /// on. Expects each of them to arrive.
  void expect_presses_to_arrive(std::size_t bytes) {
    auto stops =
        source_.publisher<PointCloud2>("stop", {.reliability = reliable, .asynchronous = by_udp_}).value();
    auto stop = app_.subscriber<PointCloud2>("stop", {.reliability = reliable}).value();
    expect_served(stops, 1);
    for (std::uint32_t i = 1; i <= presses; ++i) {
      const std::uint64_t before = published_;
      ASSERT_TRUE(eventually([&] { return published_ > before; })) << "the other topic goes on";
      stops.publish(cloud(i, bytes));
      ASSERT_TRUE(stop.wait(hang_timeout)) << i;
      const auto sample = stop.take();
      ASSERT_TRUE(sample) << i;
      EXPECT_EQ(sample->height(), i);
    }
  }

  Node source_ = open("source");
  Node app_ = open("app");
  const bool by_udp_ = GetParam() != Way::shm;
  Publisher<PointCloud2> clouds_ =
      source_.publisher<PointCloud2>("clouds", {.asynchronous = by_udp_}).value();
  std::atomic<std::uint64_t> published_{0};
};

INSTANTIATE_TEST_SUITE_P(Ways, FairTopics, testing::Values(Way::shm, Way::udp, Way::udp_sockets), way_name);

TEST_P(FairTopics, ASmallTopicThatComesIsNotStarvedByALargeOneWithoutAPause) {
  const auto taken_never = app_.subscriber<PointCloud2>("clouds").value();
  expect_served(clouds_, 1);
  const std::jthread publishing = publish_without_a_pause();
  expect_presses_to_arrive(10);
}

TEST_P(FairTopics, ALargeTopicThatComesIsNotStarvedByALargeOneWithoutAPause) {
  const auto taken_never = app_.subscriber<PointCloud2>("clouds").value();
  expect_served(clouds_, 1);
  const std::jthread publishing = publish_without_a_pause();
  expect_presses_to_arrive(large);
}

TEST_P(FairTopics, AReaderOfOneFieldIsNotStarvedByReadersOfLargeOnes) {
  const auto all = app_.subscriber<PointCloud2>("clouds").value();
  const auto data = app_.subscriber<PointCloud2, F::data>("clouds").value();
  const auto both = app_.subscriber<PointCloud2, F::data | F::width>("clouds").value();
  auto width = app_.subscriber<PointCloud2, F::width>("clouds", {.depth = 1}).value();
  expect_served(clouds_, 4);
  const std::jthread publishing = publish_without_a_pause();
  for (std::uint32_t i = 0; i < presses; ++i) {
    ASSERT_TRUE(width.wait(hang_timeout)) << i;
    EXPECT_TRUE(width.take()) << i;
  }
}

TEST_P(FairTopics, AReaderOfALargeFieldIsNotStarvedByReadersOfOthers) {
  const auto all = app_.subscriber<PointCloud2>("clouds").value();
  const auto both = app_.subscriber<PointCloud2, F::data | F::width>("clouds").value();
  auto data = app_.subscriber<PointCloud2, F::data>("clouds", {.depth = 1}).value();
  expect_served(clouds_, 3);
  const std::jthread publishing = publish_without_a_pause();
  for (std::uint32_t i = 0; i < presses; ++i) {
    ASSERT_TRUE(data.wait(hang_timeout)) << i;
    EXPECT_TRUE(data.take()) << i;
  }
}

}  // namespace
}  // namespace sft::test
