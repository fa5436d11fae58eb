// Quality of service as a user sees it, over every transport.
#include <atomic>
#include <mutex>
#include <vector>

#include <sensor_msgs/msg/Image.hpp>

#include "tests/system/fixture.h"

namespace sft::test {
namespace {

/// Events of one publisher or subscriber, which it outlives.
class EventLog {
 public:
  EventCallback callback() {
    return [this](const Event& event) {
      const std::scoped_lock lock(mutex_);
      events_.push_back(event);
    };
  }

  std::vector<Event> all(EventKind kind) const {
    const std::scoped_lock lock(mutex_);
    std::vector<Event> found;
    for (const Event& event : events_) {
      if (event.kind == kind) found.push_back(event);
    }
    return found;
  }
  bool has(EventKind kind) const { return !all(kind).empty(); }
  bool await(EventKind kind) const {
    return eventually([&] { return has(kind); });
  }

 private:
  mutable std::mutex mutex_;
  std::vector<Event> events_;
};

using sensor_msgs::msg::Image;

class QosTest : public PubSubTest {
 protected:
  EventLog offered;
  EventLog requested;
  Node a = open("a");
  Node b = open("b");
};

TEST_P(QosTest, AnIncompatiblePairNeverMatchesAndBothSidesAreToldThePolicy) {
  auto pub = a.publisher<PointCloud2>("points", {.on_event = offered.callback()}).value();
  auto sub = b.subscriber<PointCloud2, F::height>("points",
                                                  {.reliability = reliable, .on_event = requested.callback()})
                 .value();
  ASSERT_TRUE(offered.await(EventKind::incompatible_qos));
  ASSERT_TRUE(requested.await(EventKind::incompatible_qos));
  for (const EventLog* log : {&offered, &requested}) {
    const Event event = log->all(EventKind::incompatible_qos).front();
    EXPECT_EQ(event.policy, QosPolicy::reliability);
    EXPECT_EQ(event.text, "incompatible QoS: reliability best_effort is offered, reliable is requested");
    EXPECT_FALSE(log->has(EventKind::matched));
  }
  EXPECT_EQ(offered.all(EventKind::incompatible_qos).front().node, "b");
  EXPECT_EQ(pub.status().readers.at(0).incompatible_policy, QosPolicy::reliability);
  EXPECT_EQ(sub.status().writers.at(0).incompatible_policy, QosPolicy::reliability);
  EXPECT_FALSE(sub.status().writers.at(0).matched);
  pub.publish(cloud(1));
  EXPECT_FALSE(sub.wait(50ms));
}

TEST_P(QosTest, BothSidesAreToldWhenTheyMatchAndWhenTheyDoNotAnyMore) {
  std::optional pub = a.publisher<PointCloud2>("points", {.on_event = offered.callback()}).value();
  std::optional sub =
      b.subscriber<PointCloud2, F::height>("points", {.on_event = requested.callback()}).value();
  ASSERT_TRUE(offered.await(EventKind::matched));
  ASSERT_TRUE(requested.await(EventKind::matched));
  EXPECT_EQ(offered.all(EventKind::matched).front().node, "b");
  EXPECT_EQ(requested.all(EventKind::matched).front().node, "a");
  sub.reset();
  ASSERT_TRUE(offered.await(EventKind::unmatched));
  EXPECT_EQ(offered.all(EventKind::unmatched).front().text, "it is gone");
  EXPECT_FALSE(requested.has(EventKind::unmatched)) << "told after its subscriber was gone";
}

TEST_P(QosTest, AnotherTypeOfTheSameTopicIsTold) {
  auto pub = a.publisher<PointCloud2>("points", {.on_event = offered.callback()}).value();
  auto sub = b.subscriber<Image>("points", {.on_event = requested.callback()}).value();
  EXPECT_TRUE(offered.await(EventKind::incompatible_type));
  EXPECT_TRUE(requested.await(EventKind::incompatible_type));
}

TEST_P(QosTest, LossesAreTold) {
  auto pub = a.publisher<PointCloud2>("points").value();
  auto sub =
      b.subscriber<PointCloud2, F::height>("points", {.depth = 1, .on_event = requested.callback()}).value();
  auto watcher = b.subscriber<PointCloud2, F::height>("points", {.depth = 64}).value();
  expect_served(pub, 2);
  pub.publish(cloud(0));
  ASSERT_TRUE(sub.wait(5s));
  (void)sub.take();
  for (std::uint32_t i = 1; i <= 10; ++i) pub.publish(cloud(i));
  std::uint32_t seen = 0;
  while (seen < 10 && watcher.wait(5s)) {
    if (const auto sample = watcher.take()) seen = sample->height();
  }
  const auto last = sub.take();
  EXPECT_EQ(last->height(), 10U);
  ASSERT_TRUE(requested.await(EventKind::samples_lost));
  EXPECT_EQ(requested.all(EventKind::samples_lost).front().count, 9U);
}

INSTANTIATE_TEST_SUITE_P(Ways, QosTest, ::testing::Values(Way::shm, Way::udp, Way::udp_sockets), way_name);

}  // namespace
}  // namespace sft::test
