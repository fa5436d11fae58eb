// A publisher and a subscriber while the reader is moved from one path to the other, and while what is asked
// for changes: no route asks for a field that the sample at hand does not have, and the subscriber takes each
// sample at most once and counts each that it misses exactly once. Tests publish within set_routes() as well,
// which is what another thread may do.
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

/// Keeps what it sends until the test delivers it.
class PathWriter final : public WriterPort {
 public:
  /// In shared memory the reader keeps the limit of the rate.
  PathWriter(TransportKind kind, std::shared_ptr<BufferPool> pool, std::function<void()> between)
      : by_datagrams_(kind == TransportKind::udp), pool_(std::move(pool)), between_(std::move(between)) {}

  SampleHandle loan(std::size_t bytes) noexcept override {
    return refuses ? SampleHandle() : pool_->take(bytes);
  }
  bool can_send(const SampleBuffer& sample) const noexcept override {
    return by_datagrams_ || sample.owner == pool_;
  }
  void include_spares() noexcept override { with_spares_ = true; }
  SendStatus send(const SampleHandle& sample) noexcept override {
    const bool with_spares = std::exchange(with_spares_, false);
    for (const Route& route : routes_) {
      if (route.spare && !with_spares) continue;
      if (!sample->mask.contains(route.mask)) ++uncovered;
      if (by_datagrams_ && route.gate != nullptr && !route.gate->passes()) continue;
      if (by_datagrams_) mark(*sample, route);
      if (route.reader == reader_id) sent.push_back(sample);
    }
    return SendStatus::sent;
  }
  void set_routes(std::vector<Route> routes) override {
    between_();
    routes_ = std::move(routes);
    between_();
  }
  std::uint64_t bytes_sent() const noexcept override { return 0; }

  std::deque<SampleHandle> sent;
  bool refuses = false;  ///< to lend
  int uncovered = 0;     ///< routes that asked for more than the sample had

 private:
  static void mark(SampleBuffer& sample, const Route& route) {
    if (route.reader != reader_id) return;
    sample.min_period_us = route.gate == nullptr ? 0 : route.gate->min_period_us();
    sample.ordinal = route.gate == nullptr ? 0 : route.gate->ordinal();
  }

  const bool by_datagrams_;
  std::shared_ptr<BufferPool> pool_;
  std::function<void()> between_;
  std::vector<Route> routes_;
  bool with_spares_ = false;
};

class PathSwitch : public test::RandomTest {
 protected:
  explicit PathSwitch(std::chrono::nanoseconds diverted_patience = std::chrono::milliseconds(1))
      : patience(diverted_patience) {
    subscriber.ports().set(TransportKind::shm, shm_reader);
    subscriber.ports().set(TransportKind::udp, udp_reader);
  }

  std::size_t below(std::size_t end) { return random() % end; }

  void publish() {
    const PointCloud2 value{};
    shm_writer->refuses = below(100) < refused_percent;
    publisher.publish(&value);
    ++published;
  }

  /// The request of the reader may arrive late.
  std::uint32_t asked_period_us() { return periods_us[below(periods_us.size())]; }

  static Route spare(Route route) {
    route.destination = UdpAddress{};
    route.spare = true;
    return route;
  }

  /// Any serving of the reader and of a neighbour whose mask is another.
  void serve() {
    Serving serving;
    for (const EndpointId id : {reader_id, neighbour_id}) {
      const FieldMask mask = type.closed(FieldMask::from_words(type.leaves(), {{random()}}));
      const std::size_t path = below(3);
      if (path == 0) serving.shm.push_back({id, DoorbellAddress{}, mask, asked_period_us()});
      if (path == 0 && below(2) == 0) serving.spare.push_back(spare(serving.shm.back()));
      if (path == 1) serving.udp.push_back({id, UdpAddress{}, mask, asked_period_us()});
    }
    publisher.serve(serving, shm_writer);
    const std::uint32_t asked = asked_period_us();
    ASSERT_TRUE(subscriber.set_max_rate_hz(asked == 0 ? 0 : 1e6 / asked));
  }

  /// Datagrams may be lost, come late and come twice; chunks may be pushed out, but come in order.
  void move_one() {
    if (below(2) == 0 && !shm_writer->sent.empty()) {
      if (below(8) != 0) shm_reader->samples.push_back(shm_writer->sent.front());
      shm_writer->sent.pop_front();
    } else if (!udp_writer->sent.empty()) {
      const auto which =
          udp_writer->sent.begin() + static_cast<std::ptrdiff_t>(below(udp_writer->sent.size()));
      if (below(8) != 0) udp_reader->samples.push_back(*which);
      if (below(8) != 0) udp_writer->sent.erase(which);
    }
  }

  /// Each at most once, in order, and the gap before it counted.
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

  /// Delivers everything that is under way.
  static void deliver_all_of(PathWriter& writer, QueuePort& reader) {
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
  const std::chrono::nanoseconds patience;
  const TypeSupport type{TypeTable<PointCloud2>::type};
  const std::unique_ptr<DoorbellPage> bells = DoorbellPage::create();
  const std::shared_ptr<BufferPool> pool = BufferPool::make(1 << 22);
  const std::function<void()> between = [this] {
    if (below(2) == 0) publish();
  };
  const std::shared_ptr<PathWriter> udp_writer =
      std::make_shared<PathWriter>(TransportKind::udp, pool, between);
  const std::shared_ptr<PathWriter> shm_writer =
      std::make_shared<PathWriter>(TransportKind::shm, BufferPool::make(1 << 22), between);
  const std::shared_ptr<QueuePort> udp_reader = std::make_shared<QueuePort>();
  const std::shared_ptr<QueuePort> shm_reader = std::make_shared<QueuePort>();
  PublisherCore publisher{{9, "points", &type, 1 << 16}, pool, udp_writer};
  SubscriberCore subscriber{{.id = reader_id,
                             .topic = "points",
                             .type = &type,
                             .requirement = {type.full(), false},
                             .options = {},
                             .callback = nullptr,
                             .rate_changed = [] {},
                             .as_remote = nullptr,
                             .diverted_patience = patience},
                            bells->at(1),
                            nullptr};
  std::uint64_t published = 0;
  std::uint64_t first = 0;
  std::uint64_t last = 0;
};

TEST_F(PathSwitch, LosesNothingUncountedTakesNothingTwiceAndAsksForNothingThatIsNotThere) {
  run();
  const SubscriberStatus status = subscriber.status();
  EXPECT_GT(status.received, 1000U);
  EXPECT_EQ(status.received + status.lost, last - first + 1);
  EXPECT_EQ(publisher.status().published, published);
  EXPECT_EQ(shm_writer->uncovered + udp_writer->uncovered, 0);
}

TEST_F(PathSwitch, WhatSharedMemoryRefusesIsLostTakenOnceOrCountedAsWell) {
  refused_percent = 30;
  run();
  shm_writer->refuses = false;
  EXPECT_TRUE(test::eventually([&] {  // what waited for datagrams that were lost
    take();
    return shm_reader->samples.empty() && udp_reader->samples.empty() && !subscriber.available();
  }));
  const SubscriberStatus status = subscriber.status();
  EXPECT_GT(status.received, 1000U);
  EXPECT_EQ(status.received + status.lost, last - first + 1);
  EXPECT_EQ(shm_writer->uncovered + udp_writer->uncovered, 0);
}

class PatientPathSwitch : public PathSwitch {
 protected:
  PatientPathSwitch() : PathSwitch(std::chrono::hours(1)) {
    Serving serving;
    serving.shm = {{reader_id, DoorbellAddress{}, type.full()}};
    serving.spare = {spare(serving.shm.front())};
    publisher.serve(serving, shm_writer);
  }

  void expect_in_place(const Serving& by_udp, const Serving& by_shm);
};

// In shared memory a sample arrives when it is published; datagrams are under way for a while.
TEST_F(PatientPathSwitch, WhatSharedMemoryRefusesComesByUdpInItsPlaceHoweverLate) {
  refused_percent = 30;
  for (int step = 0; step < 100'000; ++step) {
    const std::size_t what = below(4);
    if (what == 0) publish();
    if (what == 1) take();
    if (what == 2) deliver_all_of(*shm_writer, *shm_reader);
    auto& under_way = udp_writer->sent;
    if (what != 3 || under_way.empty()) continue;
    deliver_all_of(*shm_writer, *shm_reader);
    udp_reader->samples.push_back(under_way.front());
    under_way.pop_front();
  }
  deliver_all_of(*shm_writer, *shm_reader);
  deliver_all_of(*udp_writer, *udp_reader);
  take();
  const SubscriberStatus status = subscriber.status();
  EXPECT_EQ(last, published);
  EXPECT_EQ(status.received, last - first + 1);
  EXPECT_EQ(status.lost, 0U);
  const PublisherStatus sent = publisher.status();
  EXPECT_EQ(sent.dropped, 0U);
  EXPECT_GT(sent.diverted.exhausted, 1000U);
  EXPECT_EQ(sent.diverted.exhausted, sent.diverted.total());
}

/// Served by UDP the reader is attached while samples are under way.
void PatientPathSwitch::expect_in_place(const Serving& by_udp, const Serving& by_shm) {
  for (int round = 0; round < 100; ++round) {
    publisher.serve(by_udp, shm_writer);
    publish();
    deliver_all_of(*shm_writer, *shm_reader);
    deliver_all_of(*udp_writer, *udp_reader);
    take();
    const std::uint64_t lost = subscriber.status().lost;
    for (int i = 0; i < 7; ++i) publish();
    publisher.serve(by_shm, shm_writer);  // samples are published meanwhile
    publish();
    deliver_all_of(*shm_writer, *shm_reader);
    take();
    deliver_all_of(*udp_writer, *udp_reader);
    take();
    ASSERT_EQ(last, published);
    ASSERT_EQ(subscriber.status().lost, lost);
  }
}

TEST_F(PatientPathSwitch, WhatIsStillUnderWayByUdpWhenTheReaderIsAttachedComesInItsPlace) {
  Serving by_udp, by_shm;
  by_udp.udp = {{reader_id, UdpAddress{}, type.full()}};
  by_shm.shm = {{reader_id, DoorbellAddress{}, type.full()}};
  expect_in_place(by_udp, by_shm);
}

TEST_F(PatientPathSwitch, WhatIsStillUnderWayByUdpComesInItsPlaceAlsoWhereOthersWereAttachedBefore) {
  const Route neighbour{neighbour_id, DoorbellAddress{}, type.full()};
  Serving by_udp, by_shm;
  by_udp.udp = {{reader_id, UdpAddress{}, type.full()}};
  by_udp.shm = {neighbour};
  by_shm.shm = {{reader_id, DoorbellAddress{}, type.full()}, neighbour};
  expect_in_place(by_udp, by_shm);
}

TEST_F(PathSwitch, FromUdpToSharedMemoryNoSampleFallsBetweenThePorts) {
  Serving by_udp, by_shm;
  by_udp.udp = {{reader_id, UdpAddress{}, type.full()}};
  by_shm.shm = {{reader_id, DoorbellAddress{}, type.full()}};
  for (int round = 0; round < 100; ++round) {
    publisher.serve({}, shm_writer);
    publisher.serve(by_udp, shm_writer);
    shm_writer->sent.clear();
    udp_writer->sent.clear();
    const std::uint64_t before = published;
    publisher.serve(by_shm, shm_writer);  // samples are published meanwhile
    publish();
    std::set<std::uint64_t> sent;
    for (const auto* samples : {&shm_writer->sent, &udp_writer->sent}) {
      for (const SampleHandle& sample : *samples) sent.insert(sample->sequence);
    }
    EXPECT_EQ(sent.size(), published - before);
  }
}

// Between samples of one gate, between gates, and between the reader's own counting and its publisher's.
TEST_F(PathSwitch, CountsEachSampleThatDidNotComeAsLostOrWithheldWhileLimitsChange) {
  periods_us = {0, 10, 30};
  run();
  ASSERT_FALSE(HasFatalFailure());
  periods_us = {0};
  ASSERT_TRUE(subscriber.set_max_rate_hz(0));
  Serving unlimited;
  unlimited.shm = {{reader_id, DoorbellAddress{}, type.full()}};
  publisher.serve(unlimited, shm_writer);
  publish();  // what was skipped before is entered, too
  shm_reader->samples.push_back(shm_writer->sent.back());
  periods_us = {0, 10, 30};
  EXPECT_TRUE(test::eventually([&] { return take(), last == published; }))
      << last;  // or it waits, for a while
  const SubscriberStatus status = subscriber.status();
  EXPECT_GT(status.received, 1000U);
  EXPECT_GT(status.withheld, 100U);
  EXPECT_EQ(status.received + status.lost + status.withheld, last - first + 1);
  EXPECT_EQ(shm_writer->uncovered + udp_writer->uncovered, 0);
}

}  // namespace
}  // namespace sft::core
