// Whole nodes on the fake transport. Discovery, negotiation, publishers and subscribers work over any
// core::Network, not only over UDP.
#include <gtest/gtest.h>

#include <sft/sft.h>
#include <cstdlib>
#include <sensor_msgs/msg/PointCloud2.hpp>

#include "core/node/node_core.h"
#include "core/platform/domain_id.h"
#include "tests/conformance/fake_transport.h"
#include "tests/support/eventually.h"
#include "tests/unit/core/seam/idle_ports.h"

namespace sft::test {
namespace {

using namespace std::chrono_literals;
using sensor_msgs::msg::PointCloud2;
using F = PointCloud2::Field;

/// A publisher and a subscriber of one topic, on two nodes that share a fake network.
class FakeNodes : public ::testing::Test {
 protected:
  Publisher<PointCloud2> publisher(const PublisherOptions& options = {}) {
    return Publisher<PointCloud2>(
        there_->open_publisher(there_, "points", type_support<PointCloud2>(), options).value());
  }
  template <Req<PointCloud2> R>
  Subscriber<PointCloud2, R> subscriber(const SubscriberOptions& options = {}) {
    return Subscriber<PointCloud2, R>(
        here_
            ->open_subscriber(here_, {.topic = "points",
                                      .type = type_support<PointCloud2>(),
                                      .requirement = {FieldMask(R.mask), R.is_recorded},
                                      .options = options,
                                      .callback = {}})
            .value());
  }
  static PointCloud2 cloud(std::uint32_t height) {
    PointCloud2 cloud;
    cloud.height = height;
    cloud.data.resize(1000);
    return cloud;
  }

 private:
  std::shared_ptr<core::NodeCore> open(const std::string& name) {
    const NodeOptions options{.name = name,
                              .domain = core::domain_id({}, std::getenv("ROS_DOMAIN_ID")).value()};
    return core::NodeCore::open(options,
                                {.memory = nullptr,
                                 .network = open_fake_transport(
                                     network_, {.max_sample_bytes = PublisherOptions{}.max_sample_bytes}),
                                 .heap = core::BufferPool::make(std::size_t{1} << 20)})
        .value();
  }

  const std::shared_ptr<FakeNetwork> network_ = make_fake_network();
  const std::shared_ptr<core::NodeCore> there_ = open("there");
  const std::shared_ptr<core::NodeCore> here_ = open("here");
};

TEST_F(FakeNodes, SendTheDeclaredFieldsAndSaveTheOthers) {
  auto points = publisher();
  auto heights = subscriber<F::height>();
  ASSERT_TRUE(points.wait_for_subscribers(1, 30s));
  EXPECT_EQ(points.publish(cloud(3)), PublishStatus::ok);
  ASSERT_TRUE(heights.wait(30s));
  const auto sample = heights.take();
  ASSERT_TRUE(sample);
  EXPECT_EQ(sample->height(), 3U);
  const PublisherStatus::Reader reader = points.status().readers.at(0);
  EXPECT_LT(reader.bytes_sent, 10U);
  EXPECT_GT(reader.bytes_saved, 1000U);
}

TEST_F(FakeNodes, SendTheRecordedFieldsOnceTheseAreKnown) {
  auto points = publisher();
  auto reads_heights = subscriber<recorded>();
  ASSERT_TRUE(points.wait_for_subscribers(1, 30s));
  EXPECT_TRUE(eventually([&] {
    points.publish(cloud(3));
    while (const auto sample = reads_heights.take()) EXPECT_EQ(sample->height(), 3U);
    return points.status().readers.at(0).mask == FieldMask(F::height);
  }));
}

TEST_F(FakeNodes, GiveALateSubscriberTheRetainedSamplesFirst) {
  auto points = publisher({.durability = Durability::transient_local, .history_depth = 2});
  for (std::uint32_t height = 1; height <= 3; ++height) points.publish(cloud(height));
  auto heights = subscriber<F::height>({.durability = Durability::transient_local});
  ASSERT_TRUE(points.wait_for_subscribers(1, 30s));
  points.publish(cloud(4));
  for (std::uint32_t height = 2; height <= 4; ++height) {
    ASSERT_TRUE(heights.wait(30s));
    const auto sample = heights.take();
    ASSERT_TRUE(sample);
    EXPECT_EQ(sample->height(), height);
  }
}

/// A transport that does nothing but return counters that the test sets.
template <class Idle>
class Counting final : public Idle {
 public:
  using Counters = core::Transport::Counters;
  explicit Counting(const Counters& counted) : counted_(counted) {}
  Counters counters() const noexcept override { return counted_; }

 private:
  const Counters counted_;
};

TEST(NodeCounts, AreThoseOfTheTransportThatTheyNameAndOfNoOther) {
  const NodeOptions options{.name = "counts",
                            .domain = core::domain_id({}, std::getenv("ROS_DOMAIN_ID")).value()};
  const auto status_of = [&](std::unique_ptr<core::SharedMemory> memory,
                             std::unique_ptr<core::Network> network) {
    return core::NodeCore::open(options, {.memory = std::move(memory),
                                          .network = std::move(network),
                                          .heap = core::BufferPool::make(std::size_t{1} << 20)})
        .value()
        ->status();
  };
  const auto counted = [](const NodeStatus& s) {
    return std::vector{s.datagrams_malformed, s.datagrams_unknown,     s.samples_incomplete,
                       s.over_limit,          s.shm_samples_malformed, s.shm_over_limit,
                       s.control_malformed,   s.control_ignored,       s.links_renewed};
  };
  using Counts = std::vector<std::uint64_t>;
  const core::Transport::Counters by_network{
      .malformed = 1, .unknown = 2, .incomplete = 4, .over_limit = 8, .rejected = 16};
  const core::Transport::Counters by_memory{.malformed = 32, .over_limit = 64};
  auto network = [&] { return std::make_unique<Counting<core::IdleNetwork>>(by_network); };
  auto memory = [&] { return std::make_unique<Counting<core::IdleSharedMemory>>(by_memory); };
  EXPECT_EQ(counted(status_of(memory(), network())), (Counts{1, 2 + 16, 4, 8, 32, 64, 0, 0, 0}));
  EXPECT_EQ(counted(status_of(nullptr, network())), (Counts{1, 2 + 16, 4, 8, 0, 0, 0, 0, 0}));
  EXPECT_EQ(counted(status_of(memory(), nullptr)), (Counts{0, 0, 0, 0, 32, 64, 0, 0, 0}));
}

}  // namespace
}  // namespace sft::test
