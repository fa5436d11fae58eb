// Quality of service through the public API, over every transport.
#include <atomic>
#include <functional>
#include <iterator>
#include <mutex>
#include <sensor_msgs/msg/Image.hpp>
#include <set>
#include <utility>
#include <vector>

#include "tests/support/pace.h"
#include "tests/system/fixture.h"

namespace sft::test {
namespace {

/// The events of one publisher or subscriber. The log must outlive the publisher or subscriber.
class EventLog {
 public:
  Event::Callback callback() {
    return [this](const Event& event) {
      const std::scoped_lock lock(mutex_);
      events_.push_back(event);
    };
  }

  std::vector<Event> all(Event::Kind kind) const {
    const std::scoped_lock lock(mutex_);
    std::vector<Event> found;
    for (const Event& event : events_) {
      if (event.kind == kind) found.push_back(event);
    }
    return found;
  }
  bool has(Event::Kind kind) const { return !all(kind).empty(); }
  bool await(Event::Kind kind) const {
    return eventually([&] { return has(kind); });
  }

 private:
  mutable std::mutex mutex_;
  std::vector<Event> events_;
};

using sensor_msgs::msg::Image;

/// Takes samples, and expects that their sequences are consecutive.
template <class S>
void expect_unbroken(S& late, int samples) {
  std::uint64_t last = 0;
  for (int taken = 0; taken < samples && late.wait(hang_timeout); ++taken) {
    const auto sample = late.take();
    if (last != 0) {
      ASSERT_EQ(sample.info().sequence, last + 1);
    }
    last = sample.info().sequence;
  }
  EXPECT_EQ(late.status().lost, 0U);
}

/// Expects that a late subscriber gets each sample once and in order, beginning with the history, while an
/// early subscriber gets live samples.
void expect_history_beside_others(Node& a, Node& b) {
  auto pub = a.publisher<PointCloud2>("points", {.durability = transient_local, .history_depth = 10}).value();
  auto early = b.subscriber<PointCloud2>("points", {.depth = 1000}).value();
  ASSERT_TRUE(eventually([&] { return pub.status().readers.size() == 1 && pub.status().readers[0].served; }));
  PointCloud2 message;
  message.data.resize(3000);
  const Ticker publishing(500us, [&](std::uint32_t i) {
    message.height = i;
    pub.publish(message);
  });
  for (int round = 0; round < 5; ++round) {
    auto late = b.subscriber<PointCloud2>("points", {.durability = transient_local, .depth = 1000}).value();
    expect_unbroken(late, 600);
  }
}

class QosTest : public PubSubTest {
 protected:
  EventLog offered;
  EventLog requested;
  Node a = open("a");
  Node b = open("b");
};

TEST_P(QosTest, AnIncompatiblePairNeverMatchesAndBothSidesAreToldThePolicy) {
  warnings_expected = true;
  auto pub = a.publisher<PointCloud2>("points", {.on_event = offered.callback()}).value();
  auto sub = b.subscriber<PointCloud2, F::height>("points",
                                                  {.reliability = reliable, .on_event = requested.callback()})
                 .value();
  ASSERT_TRUE(offered.await(Event::Kind::incompatible_qos));
  ASSERT_TRUE(requested.await(Event::Kind::incompatible_qos));
  for (const EventLog* log : {&offered, &requested}) {
    const Event event = log->all(Event::Kind::incompatible_qos).front();
    EXPECT_EQ(event.policy, QosPolicy::reliability);
    EXPECT_EQ(
        event.text,
        "incompatible QoS: reliability best_effort is offered, reliable is requested: open the publisher "
        "with .reliability = reliable, or the subscriber with .reliability = best_effort");
    EXPECT_FALSE(log->has(Event::Kind::matched));
  }
  EXPECT_EQ(offered.all(Event::Kind::incompatible_qos).front().node, "b");
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
  ASSERT_TRUE(offered.await(Event::Kind::matched));
  ASSERT_TRUE(requested.await(Event::Kind::matched));
  EXPECT_EQ(offered.all(Event::Kind::matched).front().node, "b");
  EXPECT_EQ(requested.all(Event::Kind::matched).front().node, "a");
  sub.reset();
  ASSERT_TRUE(offered.await(Event::Kind::unmatched));
  EXPECT_EQ(offered.all(Event::Kind::unmatched).front().text, "the other side has left");
  EXPECT_FALSE(requested.has(Event::Kind::unmatched)) << "told after its subscriber was gone";
}

TEST_P(QosTest, AnotherTypeOfTheSameTopicIsTold) {
  warnings_expected = true;
  auto pub = a.publisher<PointCloud2>("points", {.on_event = offered.callback()}).value();
  auto sub = b.subscriber<Image>("points", {.on_event = requested.callback()}).value();
  EXPECT_TRUE(offered.await(Event::Kind::incompatible_type));
  EXPECT_TRUE(requested.await(Event::Kind::incompatible_type));
}

TEST_P(QosTest, LossesAreTold) {
  auto pub = a.publisher<PointCloud2>("points").value();
  auto sub =
      b.subscriber<PointCloud2, F::height>("points", {.depth = 1, .on_event = requested.callback()}).value();
  auto watcher = b.subscriber<PointCloud2, F::height>("points", {.depth = 64}).value();
  expect_served(pub, 2);
  pub.publish(cloud(0));
  ASSERT_TRUE(sub.wait(hang_timeout));
  (void)sub.take();
  for (std::uint32_t i = 1; i <= 10; ++i) pub.publish(cloud(i));
  std::uint32_t seen = 0;
  while (seen < 10 && watcher.wait(hang_timeout)) {
    if (const auto sample = watcher.take()) seen = sample->height();
  }
  const auto last = sub.take();
  EXPECT_EQ(last->height(), 10U);
  ASSERT_TRUE(requested.await(Event::Kind::samples_lost));
  EXPECT_EQ(requested.all(Event::Kind::samples_lost).front().count, 9U);
}

TEST_P(QosTest, AReliableSubscriberThatComesLateGetsAllThatIsRetainedWhateverItsSize) {
  constexpr std::uint32_t retained = 16;
  const std::size_t bytes = in_shared_memory() ? 100'000 : 6'000'000;  // in the second case, more than a
                                                                       // channel keeps at a time
  auto pub =
      a.publisher<PointCloud2>(
           "points", {.reliability = reliable, .durability = transient_local, .history_depth = retained})
          .value();
  for (std::uint32_t i = 1; i <= retained; ++i) ASSERT_EQ(pub.publish(cloud(i, bytes)), PublishStatus::ok);
  auto sub = b.subscriber<PointCloud2>(
                  "points", {.reliability = reliable, .durability = transient_local, .depth = retained})
                 .value();
  for (std::uint32_t i = 1; i <= retained; ++i) {
    ASSERT_TRUE(sub.wait(20s)) << i;
    const auto sample = sub.take();
    EXPECT_EQ(sample->height(), i);
    EXPECT_EQ(sample->data().size(), bytes);
  }
  EXPECT_EQ(sub.status().lost, 0U);
}

TEST_P(QosTest, BothSidesAreToldOfMissedDeadlines) {
  warnings_expected = true;
  auto pub = a.publisher<PointCloud2>("points", {.deadline = 30ms, .on_event = offered.callback()}).value();
  auto sub =
      b.subscriber<PointCloud2, F::height>("points", {.deadline = 40ms, .on_event = requested.callback()})
          .value();
  expect_served(pub, 1);
  pub.publish(cloud(1));
  ASSERT_TRUE(offered.await(Event::Kind::deadline_missed));
  ASSERT_TRUE(requested.await(Event::Kind::deadline_missed));
  EXPECT_EQ(requested.all(Event::Kind::deadline_missed).front().node, "a");
  EXPECT_GE(pub.status().deadlines_missed, 1U);
  EXPECT_GE(sub.status().writers.at(0).deadlines_missed, 1U);
}

TEST_P(QosTest, WhoeverPublishesInTimeMissesNoDeadline) {
  auto pub = a.publisher<PointCloud2>("points", {.deadline = 1s, .on_event = offered.callback()}).value();
  auto sub =
      b.subscriber<PointCloud2, F::height>("points", {.deadline = 1s, .on_event = requested.callback()})
          .value();
  // A longer time than the deadline may pass until shared memory is ready.
  ASSERT_TRUE(eventually([&] {
    pub.publish(cloud(1));
    return served(pub) == 1;
  }));
  // A sample that is never taken, or is dropped from the queue, has still arrived in time.
  const auto missed = [&] {
    pub.publish(cloud(1));
    return offered.has(Event::Kind::deadline_missed) || requested.has(Event::Kind::deadline_missed);
  };
  EXPECT_FALSE(eventually(missed, 2500ms));
}

TEST_P(QosTest, SamplesThatWaitedBeyondTheirLifespanAreNotDelivered) {
  auto pub = a.publisher<PointCloud2>("points", {.lifespan = 50ms}).value();
  auto sub = b.subscriber<PointCloud2, F::height>("points").value();
  expect_served(pub, 1);
  const auto published = std::chrono::steady_clock::now();
  for (std::uint32_t i = 1; i <= 3; ++i) pub.publish(cloud(i));
  ASSERT_TRUE(eventually([&] { return std::chrono::steady_clock::now() > published + 60ms; }));
  EXPECT_FALSE(sub.take());
  pub.publish(cloud(4));
  EXPECT_TRUE(eventually([&] { return static_cast<bool>(sub.take()); }));
  EXPECT_TRUE(eventually([&] { return sub.status().expired == 3; })) << sub.status().expired;
  EXPECT_EQ(sub.status().lost, 0U);
}

TEST_P(QosTest, AManualPublisherLivesAsLongAsItSaysSo) {
  const PublisherOptions options{
      .liveliness = manual_by_topic, .liveliness_lease = 200ms, .on_event = offered.callback()};
  auto pub = a.publisher<PointCloud2>("points", options).value();
  auto sub = b.subscriber<PointCloud2, F::height>(
                  "points",
                  {.liveliness = manual_by_topic, .liveliness_lease = 1s, .on_event = requested.callback()})
                 .value();
  expect_served(pub, 1);
  const auto alive = [&] { return sub.status().writers.at(0).alive; };
  const auto for_a_second = [&](auto act) {
    return !eventually(
        [&] {
          act();
          return !alive();
        },
        1s);
  };
  ASSERT_TRUE(requested.await(Event::Kind::liveliness_lost));
  ASSERT_TRUE(offered.await(Event::Kind::liveliness_lost));
  EXPECT_EQ(sub.status().writers.at(0).reason, "no sign of life within its lease");
  EXPECT_TRUE(sub.status().writers.at(0).matched);
  pub.assert_liveliness();
  ASSERT_TRUE(requested.await(Event::Kind::liveliness_recovered));
  ASSERT_TRUE(offered.await(Event::Kind::liveliness_recovered));
  EXPECT_TRUE(eventually([&] {
    pub.assert_liveliness();
    return alive();
  }));
  EXPECT_TRUE(for_a_second([&] { pub.assert_liveliness(); }));
  EXPECT_TRUE(for_a_second([&] { pub.publish(cloud(1)); }));
  EXPECT_TRUE(eventually([&] { return !alive(); }));
}

TEST_P(QosTest, AnAutomaticPublisherLivesWithItsNode) {
  auto pub = a.publisher<PointCloud2>("points", {.liveliness_lease = 300ms}).value();
  auto sub = b.subscriber<PointCloud2, F::height>("points",
                                                  {.liveliness_lease = 1s, .on_event = requested.callback()})
                 .value();
  expect_served(pub, 1);
  EXPECT_FALSE(eventually([&] { return requested.has(Event::Kind::liveliness_lost); }, 1s));
}

TEST_P(QosTest, ALateSubscriberGetsTheLastSamplesInOrderAndLiveOnesBehind) {
  auto pub = a.publisher<PointCloud2>("points", {.durability = transient_local, .history_depth = 5}).value();
  for (std::uint32_t i = 1; i <= 20; ++i) pub.publish(cloud(i));
  const SubscriberOptions durable{.durability = transient_local, .depth = 64};
  auto late = b.subscriber<PointCloud2, F::height | F::data>("points", durable).value();
  auto present_only = b.subscriber<PointCloud2, F::height | F::data>("points").value();
  expect_served(pub, 2);
  pub.publish(cloud(21));
  std::vector<std::uint32_t> heights;
  while (heights.empty() || heights.back() != 21) {
    ASSERT_TRUE(late.wait(hang_timeout));
    const auto sample = late.take();
    heights.push_back(sample->height());
  }
  EXPECT_EQ(heights, (std::vector<std::uint32_t>{16, 17, 18, 19, 20, 21}));
  EXPECT_EQ(late.status().lost, 0U);
  ASSERT_TRUE(present_only.wait(hang_timeout));
  const auto first = present_only.take();
  EXPECT_EQ(first->height(), 21U);
  EXPECT_EQ(present_only.status().lost, 0U);
}

TEST_P(QosTest, BetweenHistoryAndLiveSamplesNothingIsMissingAndNothingTwice) {
  auto pub = a.publisher<PointCloud2>("points", {.durability = transient_local, .history_depth = 10}).value();
  const Ticker publishing(200us, [&](std::uint32_t i) { pub.publish(cloud(i, 3000)); });
  for (int round = 0; round < 10; ++round) {
    auto late = b.subscriber<PointCloud2>("points", {.durability = transient_local, .depth = 1000}).value();
    expect_unbroken(late, 100);
  }
}

// Another subscriber with the same mask in the same process gets live samples all the time.
TEST_P(QosTest, LiveSamplesForOthersDoNotOvertakeTheHistory) { expect_history_beside_others(a, b); }

TEST_P(QosTest, WhatHasExpiredIsNotGivenToLateSubscribers) {
  const PublisherOptions options{.durability = transient_local, .history_depth = 5, .lifespan = 50ms};
  auto pub = a.publisher<PointCloud2>("points", options).value();
  for (std::uint32_t i = 1; i <= 3; ++i) pub.publish(cloud(i));
  const auto published = std::chrono::steady_clock::now();
  ASSERT_TRUE(eventually([&] { return std::chrono::steady_clock::now() > published + 60ms; }));
  auto late = b.subscriber<PointCloud2, F::height>("points", {.durability = transient_local}).value();
  expect_served(pub, 1);
  pub.publish(cloud(4));
  ASSERT_TRUE(late.wait(hang_timeout));
  const auto first = late.take();
  EXPECT_EQ(first->height(), 4U);
}

class RateTest : public QosTest {
 protected:
  static constexpr auto period = 10ms;
  struct Heard {
    SampleInfo first, last;
    std::uint64_t samples = 0;
    std::uint64_t published() const { return last.sequence - first.sequence + 1; }
  };
  /// Takes `samples` samples of one publisher.
  template <class S>
  static Heard hear(S& sub, std::uint64_t samples) {
    Heard heard;
    while (heard.samples < samples && sub.wait(hang_timeout)) {
      const auto sample = sub.take();
      if (!sample) continue;
      heard.last = sample.info();
      if (heard.samples++ == 0) heard.first = heard.last;
    }
    return heard;
  }
  /// A maximum rate of `hz` allows one sample in each period of 1 / `hz`, and up to two unused samples can
  /// be saved. Even if the publisher runs unsteadily, the reader must have got a sample in each period in
  /// which a sample was certainly published. In all, the number of its samples must exceed the number of
  /// periods by at most two.
  void expect_rate(const Heard& heard, std::int64_t hz) {
    const std::int64_t period_ns = 1'000'000'000 / hz;
    const std::int64_t first = heard.first.source_stamp.time_since_epoch().count() / period_ns;
    const std::int64_t last = heard.last.source_stamp.time_since_epoch().count() / period_ns;
    std::set<std::int64_t> used;
    {
      const std::scoped_lock lock(publications_mutex_);
      for (const auto& [began, ended] : publications_) {
        if (began / period_ns == ended / period_ns) used.insert(began / period_ns);
      }
    }
    const auto periods = std::distance(used.upper_bound(first), used.lower_bound(last));
    EXPECT_GE(static_cast<std::int64_t>(heard.samples), periods + 1);
    EXPECT_LE(static_cast<std::int64_t>(heard.samples), last - first + 1 + 2);
  }

  Publisher<PointCloud2> pub = a.publisher<PointCloud2>("points").value();
  const std::function<void(std::uint32_t)> publish = [this](std::uint32_t i) {
    const std::int64_t began = realtime_ns();
    pub.publish({.height = i});
    const std::scoped_lock lock(publications_mutex_);
    publications_.emplace_back(began, realtime_ns());
  };

 private:
  static std::int64_t realtime_ns() {
    using std::chrono::system_clock;
    return std::chrono::duration_cast<std::chrono::nanoseconds>(system_clock::now().time_since_epoch())
        .count();
  }

  std::mutex publications_mutex_;
  /// The times of the begin and the end of each call of publish().
  std::vector<std::pair<std::int64_t, std::int64_t>> publications_;
};

TEST_P(RateTest, ASlowReaderOfAFastPublisherGetsItsRateAndLosesNothing) {
  auto sub = b.subscriber<PointCloud2, F::height>("points", {.depth = 64, .max_rate_hz = 10}).value();
  expect_served(pub, 1);
  EXPECT_EQ(pub.status().readers.at(0).max_rate_hz, 10);
  const Ticker ticker(period, publish, Keeps::rate);
  const Heard heard = hear(sub, 15);
  ASSERT_EQ(heard.samples, 15U);
  expect_rate(heard, 10);
  const SubscriberStatus status = sub.status();
  EXPECT_EQ(status.lost, 0U);
  EXPECT_GE(status.withheld, 100U);
  EXPECT_EQ(status.received + status.withheld, heard.published());
  EXPECT_EQ(status.writers.at(0).withheld, status.withheld);
  EXPECT_GE(pub.status().readers.at(0).withheld, status.withheld);
}

TEST_P(RateTest, ReadersOfOneProcessHaveEachTheirOwn) {
  auto all = b.subscriber<PointCloud2, F::height>("points", {.depth = 1000}).value();
  auto slow = b.subscriber<PointCloud2, F::height>("points", {.depth = 64, .max_rate_hz = 20}).value();
  auto slower = b.subscriber<PointCloud2, F::height>("points", {.depth = 64, .max_rate_hz = 5}).value();
  expect_served(pub, 3);
  const Ticker ticker(period, publish, Keeps::rate);
  for (auto* sub : {&slow, &slower}) (void)hear(*sub, 3);  // the first samples may use up the saved budget
  const Heard of_slow = hear(slow, 20);
  expect_rate(of_slow, 20);
  expect_rate(hear(slower, 7), 5);
  const Heard of_all = hear(all, 120);
  EXPECT_EQ(of_all.samples, of_all.published()) << "every one that was published meanwhile";
  EXPECT_EQ(all.status().withheld, 0U);
  EXPECT_EQ(slow.status().lost, 0U);
  EXPECT_EQ(slower.status().lost, 0U);
}

TEST_P(RateTest, TheRateChangesWhileSamplesFlow) {
  auto sub = b.subscriber<PointCloud2, F::height>("points", {.max_rate_hz = 5}).value();
  expect_served(pub, 1);
  const Ticker ticker(period, publish, Keeps::rate);
  (void)hear(sub, 3);
  ASSERT_TRUE(sub.set_max_rate_hz(0));
  ASSERT_TRUE(eventually([&] { return pub.status().readers.at(0).max_rate_hz == 0; }));
  (void)hear(sub, 10);
  const Heard of_all = hear(sub, 30);
  EXPECT_EQ(of_all.samples, of_all.published()) << "every one that was published meanwhile";
  ASSERT_TRUE(sub.set_max_rate_hz(10));
  ASSERT_TRUE(eventually([&] { return pub.status().readers.at(0).max_rate_hz == 10; }));
  (void)hear(sub, 12);  // these samples were under way when the rate changed
  expect_rate(hear(sub, 8), 10);
  EXPECT_EQ(sub.status().lost, 0U);
  EXPECT_FALSE(sub.set_max_rate_hz(-1));
}

TEST_P(RateTest, CallbacksComeAtTheRateToo) {
  std::atomic<std::uint64_t> called{0};
  auto sub =
      b.subscriber<PointCloud2, F::height>("points", [&](const auto&) { ++called; }, {.max_rate_hz = 10})
          .value();
  expect_served(pub, 1);
  const Ticker ticker(period, publish, Keeps::rate);
  EXPECT_TRUE(eventually([&] { return called >= 10; }));
  EXPECT_TRUE(eventually([&] { return sub.status().withheld >= 80; }));
  EXPECT_EQ(sub.status().lost, 0U);
}

// By default the history is sent by UDP. After that, live samples are sent in shared memory.
TEST(HistoryTest, ALateSubscriberOnTheSameHostGetsTheHistoryAndChangesOverToSharedMemory) {
  const auto options = [](const char* name) {
    NodeOptions o{.name = name};
    o.shm.daemon_idle_exit = 5s;
    return o;
  };
  Node a = Node::open(options("a")).value();
  Node b = Node::open(options("b")).value();
  ASSERT_TRUE(eventually([&] { return a.status().shm_ready && b.status().shm_ready; }));
  auto pub = a.publisher<PointCloud2>("points", {.durability = transient_local, .history_depth = 5}).value();
  std::uint32_t published = 0;
  for (; published < 20;) pub.publish({.height = ++published});
  auto late =
      b.subscriber<PointCloud2, F::height>("points", {.durability = transient_local, .depth = 1000}).value();
  std::uint32_t next = 16;
  bool by_shm = false;
  EXPECT_TRUE(eventually([&] {
    if (next > 20) pub.publish({.height = ++published});
    while (const auto sample = late.take()) {
      EXPECT_EQ(sample->height(), next);
      next = sample->height() + 1;
      by_shm = sample.info().transport == TransportKind::shm;
    }
    return by_shm;
  }));
  EXPECT_EQ(late.status().lost, 0U);
}

TEST(HistoryTest, LiveSamplesForOthersInSharedMemoryDoNotOvertakeIt) {
  NodeOptions options{.name = "a"};
  options.shm.daemon_idle_exit = 5s;
  Node a = Node::open(options).value();
  options.name = "b";
  Node b = Node::open(options).value();
  ASSERT_TRUE(eventually([&] { return a.status().shm_ready && b.status().shm_ready; }));
  expect_history_beside_others(a, b);
}

INSTANTIATE_TEST_SUITE_P(Ways, RateTest, ::testing::Values(Way::shm, Way::udp, Way::udp_sockets), way_name);
INSTANTIATE_TEST_SUITE_P(Ways, QosTest, ::testing::Values(Way::shm, Way::udp, Way::udp_sockets), way_name);

/// Expects that 3 MB take more than 250 ms, because a limit of 10 MB/s is set.
void expect_paced(const NodeOptions& sending, const PublisherOptions& published) {
  Node a = Node::open(sending).value();
  Node b = Node::open(node_options(Way::udp, "b")).value();
  auto publisher = a.publisher<PointCloud2>("points", published).value();
  auto subscriber = b.subscriber<PointCloud2>("points", {.reliability = reliable, .depth = 100}).value();
  ASSERT_TRUE(eventually([&] {
    const auto readers = publisher.status().readers;
    return readers.size() == 1 && readers[0].served;
  }));
  PointCloud2 cloud;
  cloud.data.resize(100'000);
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0; i < 30; ++i) EXPECT_EQ(publisher.publish(cloud), PublishStatus::ok);
  for (int i = 0; i < 30; ++i) {
    ASSERT_TRUE(subscriber.wait(hang_timeout)) << i;
    ASSERT_TRUE(subscriber.take());
  }
  const auto took = std::chrono::steady_clock::now() - begin;
  EXPECT_GT(took, 250ms);
  EXPECT_EQ(subscriber.status().lost, 0U);
}

TEST(Rates, OfANodeAreKept) {
  NodeOptions sending = node_options(Way::udp, "a");
  sending.udp.max_bytes_per_s = 10'000'000;
  expect_paced(sending, {.reliability = reliable});
}

TEST(Rates, OfAPublisherAreKept) {
  expect_paced(node_options(Way::udp, "a"), {.reliability = reliable, .max_bytes_per_s = 10'000'000});
}

}  // namespace
}  // namespace sft::test
