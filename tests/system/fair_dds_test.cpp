// Callbacks of one node are called in turns, whether their samples come from nodes of SFT or of plain DDS.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <utility>

#include "tests/system/vanilla_fixture.h"

namespace sft::test {
namespace {

/// The callbacks of one node, of which one is slow and always has a next sample.
class FairDdsCallbacks : public VanillaTest {
 protected:
  static constexpr std::uint32_t presses = 80;

  template <class Press>
  void expect_presses_to_be_called(Press press) {
    std::atomic<std::uint32_t> stops{0};
    const auto stop =
        node_.subscriber<PointCloud2>("stop", [&](const auto&) { ++stops; }, {.reliability = reliable})
            .value();
    std::uint32_t starved = 0;
    for (std::uint32_t i = 1; i <= presses && starved == 0; ++i) {
      press(i);
      if (!eventually([&] { return stops == i; })) starved = presses - stops;
    }
    std::printf("starved callbacks: %u of %u, %s\n", starved, presses,
                testing::UnitTest::GetInstance()->current_test_info()->name());
    EXPECT_EQ(starved, 0U);
  }
  static void work() {
    const auto end = std::chrono::steady_clock::now() + 5ms;
    while (std::chrono::steady_clock::now() < end) continue;
  }

  Node node_ = open(Way::udp);
};

TEST_F(FairDdsCallbacks, OfADdsTopicAreNotStarvedByASlowOneOfAnSftTopic) {
  auto camera = node_.publisher<PointCloud2>("camera").value();
  std::atomic<std::uint32_t> images{0};
  const auto detect = node_
                          .subscriber<PointCloud2>("camera",
                                                   [&](const auto&) {
                                                     work();
                                                     camera.publish(cloud(++images));
                                                   })
                          .value();
  ASSERT_TRUE(camera.wait_for_subscribers(1, hang_timeout));
  VanillaWriter button(network_.host(1), {.topic = "rt/stop"});
  bool is_matched = false;
  expect_presses_to_be_called([&](std::uint32_t i) {
    if (!std::exchange(is_matched, true)) {
      ASSERT_TRUE(button.matches(1));
      for (int image = 0; image < 4; ++image) camera.publish(cloud(1));
      ASSERT_TRUE(eventually([&] { return images > 10; }));
    }
    button.write_cloud(i);
  });
}

TEST_F(FairDdsCallbacks, AreNotStarvedByASlowOneOfADdsTopic) {
  VanillaWriter camera(network_.host(1), {.topic = "rt/camera"});
  std::atomic<std::uint32_t> images{0};
  const auto detect = node_
                          .subscriber<PointCloud2>("camera",
                                                   [&](const auto&) {
                                                     camera.write_cloud(++images);
                                                     work();
                                                   })
                          .value();
  ASSERT_TRUE(camera.matches(1) && hears(detect, 1));
  for (std::uint32_t image = 1; image <= 8; ++image) camera.write_cloud(image);
  ASSERT_TRUE(eventually([&] { return images > 10; }));
  auto button = node_.publisher<PointCloud2>("stop", {.reliability = reliable}).value();
  expect_presses_to_be_called([&](std::uint32_t i) {
    ASSERT_TRUE(i > 1 || button.wait_for_subscribers(1, hang_timeout));
    button.publish(cloud(i));
  });
}

}  // namespace
}  // namespace sft::test
