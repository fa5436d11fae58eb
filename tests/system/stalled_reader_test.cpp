// Two reliable subscribers on another host. One of them is stopped for longer than the publisher can keep the
// samples that it misses.
#include <gtest/gtest.h>

#include <sft/sft.h>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <vector>

#include "tests/support/eventually.h"
#include "tests/support/isolated_host.h"
#include "tests/support/pace.h"
#include "tests/system/node_process.h"

namespace sft::test {
namespace {

using sensor_msgs::msg::PointCloud2;
using F = PointCloud2::Field;
using namespace std::chrono_literals;

constexpr std::size_t sample_bytes = 200'000;
constexpr std::uint32_t samples_published = 600;  // 120 MB, of which a publisher keeps 64 MiB
constexpr std::uint32_t kept = 240;               // the minimum number of samples that a publisher keeps

struct Kept {
  std::atomic<bool> failed{false};
  std::atomic<std::size_t> served{0};
  std::atomic<std::uint32_t> wanted{0};  ///< the number of samples to publish
  std::atomic<std::uint32_t> count{0};
};

struct TakenInOrder {
  std::atomic<bool> failed{false};
  std::atomic<bool> out_of_order{false};
  std::atomic<std::uint32_t> last{0};
  std::atomic<std::uint64_t> count{0}, reported{0};
  std::atomic<std::uint32_t> in_a_row{0};  ///< the length of the latest run of samples without a gap
};

void publish_many(Node& node, Kept& published) {
  auto publisher = node.publisher<PointCloud2>("points", {.reliability = reliable}).value();
  const std::vector<std::uint8_t> data(sample_bytes);
  for (Pace pace(2ms);; pace.await_turn()) {
    const PublisherStatus status = publisher.status();
    published.served =
        static_cast<std::size_t>(std::ranges::count_if(status.readers, &PublisherStatus::Reader::served));
    if (published.count >= published.wanted) continue;
    publisher.publish({.height = published.count + 1, .data = data});
    ++published.count;
  }
}

void take_in_order(Node& node, TakenInOrder& taken) {
  auto subscriber = node.subscriber<PointCloud2, F::height | F::data>(
                            "points", {.reliability = reliable, .depth = 2 * samples_published})
                        .value();
  for (;;) {
    subscriber.wait(5ms);
    while (const auto sample = subscriber.take()) {
      if (sample->height() <= taken.last) taken.out_of_order = true;
      taken.reported += sample.info().lost_before;
      if (sample.info().lost_before != 0) taken.in_a_row = 0;
      ++taken.in_a_row;
      ++taken.count;
      taken.last = sample->height();
    }
  }
}

TEST(StalledReader, LosesTheOldestAndKnowsItWhileAnotherGetsAllInTime) {
  if (!isolation_refusal().empty()) GTEST_SKIP() << isolation_refusal();
  const auto network = hosts::EmulatedNetwork::create(2);
  if (!network) GTEST_SKIP() << network.error().message;
  const NodeOptions options{.transport = TransportChoice::udp};
  const NodeProcessWith<Kept> publisher(network->host(0), options, publish_many);
  const NodeProcessWith<TakenInOrder> good(network->host(1), options, take_in_order);
  const NodeProcessWith<TakenInOrder> stalled(network->host(1), options, take_in_order);
  Kept& published = publisher.report();
  const auto has = [](const NodeProcessWith<TakenInOrder>& subscriber, std::uint32_t last) {
    return eventually([&] { return subscriber.report().last == last; });
  };
  ASSERT_TRUE(eventually([&] { return published.served == 2; }));
  published.wanted = 1;
  ASSERT_TRUE(has(good, 1));
  ASSERT_TRUE(has(stalled, 1));

  stalled.hold_up();
  published.wanted = samples_published;
  ASSERT_TRUE(has(good, samples_published)) << "while the other one is held up: nobody waits for it";
  EXPECT_EQ(good.report().reported, 0U);
  EXPECT_EQ(good.report().count, samples_published);
  stalled.let_go();
  ASSERT_TRUE(has(stalled, samples_published)) << stalled.report().last;
  const TakenInOrder& taken = stalled.report();
  EXPECT_FALSE(taken.out_of_order);
  EXPECT_GT(taken.reported, 0U);
  EXPECT_EQ(taken.count + taken.reported, samples_published);
  EXPECT_GE(taken.in_a_row, kept) << "what the publisher still had";
  EXPECT_EQ(published.served, 2U);
}

}  // namespace
}  // namespace sft::test
