// A publisher and a subscriber, while the subscriber changes from one path to the other, and while its
// request changes. No route requests a field that the present sample lacks. The subscriber takes each sample
// at most once, and counts each missed sample exactly once. Tests also publish within set_routes(), as
// another thread may do.
#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <functional>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <set>

#include "core/publish/publisher_core.h"
#include "core/subscribe/subscriber_core.h"
#include "tests/support/eventually.h"
#include "tests/support/test_seed.h"
#include "tests/unit/core/seam/queue_port.h"

namespace sft::core {
namespace {

using namespace detail;

using sensor_msgs::msg::PointCloud2;
constexpr EndpointId reader_id = 1;
constexpr EndpointId neighbour_id = 2;

/// A path that holds its samples until the test delivers them.
class Path {
 public:
  explicit Path(std::function<void()> between) : between_(std::move(between)) {}

  std::deque<SampleHandle> sent;
  int uncovered = 0;  ///< the number of routes that requested more than the sample had

 protected:
  void put(std::vector<Route> routes) {
    between_();
    routes_ = std::move(routes);
    between_();
  }
  const std::vector<Route>& routes() const { return routes_; }

 private:
  std::function<void()> between_;
  std::vector<Route> routes_;
};

/// The path through shared memory. On this path the reader itself limits its rate.
class MemoryPath final : public IdleLendingWriter, public Path {
 public:
  MemoryPath(std::shared_ptr<BufferPool> pool, std::function<void()> between)
      : Path(std::move(between)), pool_(std::move(pool)) {}

  SampleHandle loan(std::size_t bytes) noexcept override {
    return refuses ? SampleHandle() : pool_->take(bytes);
  }
  bool can_send(const SampleBuffer& sample) const noexcept override { return sample.owner == pool_; }
  SendStatus send(const SampleHandle& sample) noexcept override {
    for (const Route& route : routes()) {
      if (!sample->mask.contains(route.selection.mask())) ++uncovered;
      if (route.reader == reader_id) sent.push_back(sample);
    }
    return SendStatus::sent;
  }
  void set_routes(std::vector<Route> routes) override { put(std::move(routes)); }

  bool refuses = false;  ///< whether the port refuses to lend memory

 private:
  std::shared_ptr<BufferPool> pool_;
};

class NetworkPath final : public IdleNetworkWriter, public Path {
 public:
  using Path::Path;
  void set_routes(std::vector<Route> routes) override { put(std::move(routes)); }

 private:
  SendStatus send_begun(const SampleHandle& sample, Reach reach) noexcept override {
    for (const Route& route : routes()) {
      if (route.fallback && reach == Reach::usual_routes) continue;
      if (!sample->mask.contains(route.selection.mask())) ++uncovered;
      if (route.gate != nullptr && !route.gate->passes()) continue;
      if (route.reader != reader_id) continue;
      sample->min_period_us = route.gate == nullptr ? 0 : route.gate->min_period_us();
      sample->ordinal = route.gate == nullptr ? 0 : route.gate->ordinal();
      sent.push_back(sample);
    }
    return SendStatus::sent;
  }
};

class PathSwitch : public test::RandomTest {
 protected:
  explicit PathSwitch(std::chrono::nanoseconds diverted_timeout = std::chrono::milliseconds(1))
      : hang_timeout(diverted_timeout) {
    subscriber.ports().set_memory(memory_reader);
    subscriber.ports().set_network(network_reader);
  }

  std::size_t below(std::size_t end) { return random() % end; }

  void publish() {
    const PointCloud2 value{};
    memory_writer->refuses = below(100) < refused_percent;
    publisher.publish(&value);
    ++published;
  }

  /// Returns a random period for a request. Writer and reader may have different periods at a time, because
  /// requests may arrive late.
  std::uint32_t asked_period_us() { return periods_us[below(periods_us.size())]; }

  static Route fallback(Route route) {
    route.destination = UdpAddress{};
    route.fallback = true;
    return route;
  }

  /// Puts random routes in force, for the reader and for a neighbour with another mask.
  void serve() {
    Serving serving;
    for (const EndpointId id : {reader_id, neighbour_id}) {
      const FieldMask mask = type.closed(FieldMask::from_words(type.leaves(), {{random()}}));
      const std::size_t path = below(3);
      if (path == 0) serving.memory.push_back({id, DoorbellAddress{}, mask, asked_period_us()});
      if (path == 0 && below(2) == 0) serving.fallback.push_back(fallback(serving.memory.back()));
      if (path == 1) serving.network.push_back({id, UdpAddress{}, mask, asked_period_us()});
    }
    publisher.serve(serving, memory_writer);
    const std::uint32_t asked = asked_period_us();
    ASSERT_TRUE(subscriber.feed().set_max_rate_hz(asked == 0 ? 0 : 1e6 / asked));
  }

  /// Delivers or drops one sample. Datagrams may be lost, arrive late and arrive twice. Chunks may be
  /// displaced, but arrive in order.
  void move_one() {
    if (below(2) == 0 && !memory_writer->sent.empty()) {
      if (below(8) != 0) memory_reader->samples.push_back(memory_writer->sent.front());
      memory_writer->sent.pop_front();
    } else if (!network_writer->sent.empty()) {
      const auto which =
          network_writer->sent.begin() + static_cast<std::ptrdiff_t>(below(network_writer->sent.size()));
      if (below(8) != 0) network_reader->samples.push_back(*which);
      if (below(8) != 0) network_writer->sent.erase(which);
    }
  }

  /// Takes all samples. Expects that they are in order, that no sample is taken twice, and that gaps are
  /// counted.
  void take() {
    while (const untyped::Sample sample = subscriber.take()) {
      const SampleInfo& info = sample.info();
      const std::uint64_t gap = last == 0 ? 0 : info.sequence - last - 1;
      ASSERT_GT(info.sequence, last);
      const bool unlimited = periods_us.size() == 1;
      ASSERT_EQ(info.lost_before, unlimited ? gap : std::min(gap, info.lost_before));
      if (last == 0) first = info.sequence;
      last = info.sequence;
    }
  }

  /// Delivers all samples of the path that are under way.
  static void deliver_all_of(Path& writer, Queue& reader) {
    for (; !writer.sent.empty(); writer.sent.pop_front()) reader.samples.push_back(writer.sent.front());
  }

  void run() {
    for (int step = 0; step < 100'000; ++step) {
      const std::size_t what = below(8);
      if (what == 0) serve();
      if (what == 1 || what == 2) publish();
      if (what >= 3 && what <= 6) move_one();
      if (what == 7) take();
      ASSERT_FALSE(HasFatalFailure()) << "in step " << step;
    }
    take();
  }

  std::vector<std::uint32_t> periods_us{0};
  std::size_t refused_percent = 0;
  const std::chrono::nanoseconds hang_timeout;
  const TypeSupport type{TypeTable<PointCloud2>::type};
  const std::unique_ptr<DoorbellPage> bells = DoorbellPage::create();
  const std::shared_ptr<BufferPool> pool = BufferPool::make(1 << 22);
  const std::function<void()> between = [this] {
    if (below(2) == 0) publish();
  };
  const std::shared_ptr<NetworkPath> network_writer = std::make_shared<NetworkPath>(between);
  const std::shared_ptr<MemoryPath> memory_writer =
      std::make_shared<MemoryPath>(BufferPool::make(1 << 22), between);
  const std::shared_ptr<NetworkQueue> network_reader = std::make_shared<NetworkQueue>();
  const std::shared_ptr<MemoryQueue> memory_reader = std::make_shared<MemoryQueue>();
  PublisherCore publisher{{9, "points", &type, 1 << 16}, pool, network_writer};
  SubscriberCore subscriber{{.topic = "points",
                             .type = &type,
                             .feeds = {{.id = reader_id, .selection = type.full()}},
                             .options = {},
                             .callback = nullptr,
                             .copies = nullptr,
                             .diverted_timeout = hang_timeout},
                            bells->at(1),
                            nullptr};
  std::uint64_t published = 0;
  std::uint64_t first = 0;
  std::uint64_t last = 0;
};

TEST_F(PathSwitch, LosesNothingUncountedTakesNothingTwiceAndAsksForNothingThatIsNotThere) {
  run();
  const SubscriberStatus status = subscriber.feed().status();
  EXPECT_GT(status.received, 1000U);
  EXPECT_EQ(status.received + status.lost, last - first + 1);
  EXPECT_EQ(publisher.status().published, published);
  EXPECT_EQ(memory_writer->uncovered + network_writer->uncovered, 0);
}

TEST_F(PathSwitch, WhatSharedMemoryRefusesIsLostTakenOnceOrCountedAsWell) {
  refused_percent = 30;
  run();
  memory_writer->refuses = false;
  EXPECT_TRUE(test::eventually([&] {  // Some samples still wait for lost datagrams.
    take();
    return memory_reader->samples.empty() && network_reader->samples.empty() && !subscriber.available();
  }));
  const SubscriberStatus status = subscriber.feed().status();
  EXPECT_GT(status.received, 1000U);
  EXPECT_EQ(status.received + status.lost, last - first + 1);
  EXPECT_EQ(memory_writer->uncovered + network_writer->uncovered, 0);
}

class PathSwitchWithinTimeout : public PathSwitch {
 protected:
  PathSwitchWithinTimeout() : PathSwitch(std::chrono::hours(1)) {
    Serving serving;
    serving.memory = {{reader_id, DoorbellAddress{}, type.full()}};
    serving.fallback = {fallback(serving.memory.front())};
    publisher.serve(serving, memory_writer);
  }

  void expect_in_place(const Serving& over_network, const Serving& in_memory);
};

// In this test samples in shared memory arrive at once, and datagrams arrive some time later.
TEST_F(PathSwitchWithinTimeout, WhatSharedMemoryRefusesComesByUdpInItsPlaceHoweverLate) {
  refused_percent = 30;
  for (int step = 0; step < 100'000; ++step) {
    const std::size_t what = below(4);
    if (what == 0) publish();
    if (what == 1) take();
    if (what == 2) deliver_all_of(*memory_writer, *memory_reader);
    auto& under_way = network_writer->sent;
    if (what != 3 || under_way.empty()) continue;
    deliver_all_of(*memory_writer, *memory_reader);
    network_reader->samples.push_back(under_way.front());
    under_way.pop_front();
  }
  deliver_all_of(*memory_writer, *memory_reader);
  deliver_all_of(*network_writer, *network_reader);
  take();
  const SubscriberStatus status = subscriber.feed().status();
  EXPECT_EQ(last, published);
  EXPECT_EQ(status.received, last - first + 1);
  EXPECT_EQ(status.lost, 0U);
  const PublisherStatus sent = publisher.status();
  EXPECT_EQ(sent.dropped, 0U);
  EXPECT_GT(sent.diverted.exhausted, 1000U);
  EXPECT_EQ(sent.diverted.exhausted, sent.diverted.total());
}

/// The reader is served by UDP first. Then it is attached to shared memory while datagrams are under way.
void PathSwitchWithinTimeout::expect_in_place(const Serving& over_network, const Serving& in_memory) {
  for (int round = 0; round < 100; ++round) {
    publisher.serve(over_network, memory_writer);
    publish();
    deliver_all_of(*memory_writer, *memory_reader);
    deliver_all_of(*network_writer, *network_reader);
    take();
    const std::uint64_t lost = subscriber.feed().status().lost;
    for (int i = 0; i < 7; ++i) publish();
    publisher.serve(in_memory, memory_writer);  // also publishes samples while the routes change
    publish();
    deliver_all_of(*memory_writer, *memory_reader);
    take();
    deliver_all_of(*network_writer, *network_reader);
    take();
    ASSERT_EQ(last, published);
    ASSERT_EQ(subscriber.feed().status().lost, lost);
  }
}

TEST_F(PathSwitchWithinTimeout, WhatIsStillUnderWayByUdpWhenTheReaderIsAttachedComesInItsPlace) {
  Serving over_network, in_memory;
  over_network.network = {{reader_id, UdpAddress{}, type.full()}};
  in_memory.memory = {{reader_id, DoorbellAddress{}, type.full()}};
  expect_in_place(over_network, in_memory);
}

TEST_F(PathSwitchWithinTimeout, WhatIsStillUnderWayByUdpComesInItsPlaceAlsoWhereOthersWereAttachedBefore) {
  const Route neighbour{neighbour_id, DoorbellAddress{}, type.full()};
  Serving over_network, in_memory;
  over_network.network = {{reader_id, UdpAddress{}, type.full()}};
  over_network.memory = {neighbour};
  in_memory.memory = {{reader_id, DoorbellAddress{}, type.full()}, neighbour};
  expect_in_place(over_network, in_memory);
}

TEST_F(PathSwitch, FromUdpToSharedMemoryNoSampleFallsBetweenThePorts) {
  Serving over_network, in_memory;
  over_network.network = {{reader_id, UdpAddress{}, type.full()}};
  in_memory.memory = {{reader_id, DoorbellAddress{}, type.full()}};
  for (int round = 0; round < 100; ++round) {
    publisher.serve({}, memory_writer);
    publisher.serve(over_network, memory_writer);
    memory_writer->sent.clear();
    network_writer->sent.clear();
    const std::uint64_t before = published;
    publisher.serve(in_memory, memory_writer);  // also publishes samples while the routes change
    publish();
    std::set<std::uint64_t> sent;
    for (const auto* samples : {&memory_writer->sent, &network_writer->sent}) {
      for (const SampleHandle& sample : *samples) sent.insert(sample->sequence);
    }
    EXPECT_EQ(sent.size(), published - before);
  }
}

// Limits change between samples of one gate, between gates, and when the counting moves from the reader to
// the publisher or back.
TEST_F(PathSwitch, CountsEachSampleThatDidNotComeAsLostOrWithheldWhileLimitsChange) {
  periods_us = {0, 10, 30};
  run();
  ASSERT_FALSE(HasFatalFailure());
  periods_us = {0};
  ASSERT_TRUE(subscriber.feed().set_max_rate_hz(0));
  Serving unlimited;
  unlimited.memory = {{reader_id, DoorbellAddress{}, type.full()}};
  publisher.serve(unlimited, memory_writer);
  publish();  // makes the subscriber count the samples before this one
  memory_reader->samples.push_back(memory_writer->sent.back());
  periods_us = {0, 10, 30};
  EXPECT_TRUE(test::eventually([&] { return take(), last == published; }))
      << last;  // the last sample may have to wait for earlier ones
  const SubscriberStatus status = subscriber.feed().status();
  EXPECT_GT(status.received, 1000U);
  EXPECT_GT(status.withheld, 100U);
  EXPECT_EQ(status.received + status.lost + status.withheld, last - first + 1);
  EXPECT_EQ(memory_writer->uncovered + network_writer->uncovered, 0);
}

}  // namespace
}  // namespace sft::core
