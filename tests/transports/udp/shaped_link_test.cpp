// Small samples and large samples at the same time, on a link that is far too slow for the large samples.
#include <gtest/gtest.h>
#include <sched.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "tests/support/isolated_host.h"
#include "tests/support/pace.h"
#include "tests/support/standstill_monitor.h"
#include "tests/transports/udp/another_host.h"
#include "tests/transports/udp/backends.h"
#include "tests/transports/udp/endpoints.h"
#include "udp_transport/udp_transport.h"

namespace sft::udp {
namespace {

using namespace std::chrono_literals;
using test::make_image;
using test::Publisher;
using test::Subscriber;

constexpr auto bound = 20ms;
constexpr auto duration = 5s, duration_alone = 1s;
constexpr auto pause = 5ms;
constexpr double link_bytes_per_s = 12.5e6;

using sft::test::StandstillMonitor;
using WatchedClock = StandstillMonitor::Clock;
using Standstills = std::vector<StandstillMonitor::Standstill>;

/// A publisher on this host, and its reader on the other host.
struct Topic {
  Topic(core::Network& near, core::Network& far, const Publisher::Reader& reader, core::EndpointId id,
        std::uint32_t depth)
      : publisher(near, id), subscriber(far, {"*"}, depth, id) {
    reader.reliable ? subscriber.listen_reliably_to(id) : subscriber.listen_to(id);
    publisher.serve({reader});
  }
  Publisher publisher;
  Subscriber subscriber;
};

/// A topic of small samples. Measures the time until each arrives.
class SmallTopic {
 public:
  SmallTopic(core::Network& near, core::Network& far, const Publisher::Reader& reader, core::EndpointId id)
      : topic_(near, far, reader, id, 2000) {}
  void publish() {
    published_at_.push_back(WatchedClock::now());
    topic_.publisher.publish(make_image(100));
  }
  /// Returns the sorted times from publication to arrival of all samples since the last call. Times during
  /// which the machine stood still are subtracted. A lost sample counts as the longest time, unless the
  /// machine stood still while the sample was under way.
  std::vector<WatchedClock::duration> times(const Standstills& standstills = {}) {
    std::vector<std::int64_t> came_ns(published_at_.size());
    for (const auto& sample : topic_.subscriber.await(published_at_.size(), 1s))
      came_ns.at(sample->header().sequence - 1) = sample->receive_stamp_ns;
    std::vector<WatchedClock::duration> times;
    for (; done_ < published_at_.size(); ++done_) {
      const WatchedClock::time_point from = published_at_[done_];
      const bool lost = came_ns[done_] == 0;
      const WatchedClock::time_point until =
          lost ? from + bound : WatchedClock::time_point(came_ns[done_] * 1ns);
      const WatchedClock::duration still = StandstillMonitor::within(standstills, from, until);
      if (!lost)
        times.push_back(until - from - still);
      else if (still == 0ns)
        times.push_back(WatchedClock::duration::max());
    }
    std::ranges::sort(times);
    return times;
  }

 private:
  Topic topic_;
  std::vector<WatchedClock::time_point> published_at_;
  std::size_t done_ = 0;
};

/// Returns the time that so many of 100 samples took at most. `sorted` is not empty unless the machine stood
/// still all the time.
WatchedClock::duration percentile(const std::vector<WatchedClock::duration>& sorted, std::size_t percent) {
  return sorted.empty() ? 0ns : sorted[sorted.size() * percent / 100];
}

/// A topic of samples of 1 MB.
class LargeTopic {
 public:
  LargeTopic(core::Network& near, core::Network& far, const Publisher::Reader& reader, core::EndpointId id)
      : topic_(near, far, reader, id, 4) {}
  static constexpr std::size_t bytes = 1'000'000;
  void publish() { topic_.publisher.port().send(topic_.publisher.make(image_)); }
  std::size_t came() { return topic_.subscriber.await(0).size(); }

 private:
  const test::Image image_ = make_image(bytes);
  Topic topic_;
};

/// Binds this thread, and the threads that it starts, to one CPU. If threads of one side ran on two CPUs, the
/// kernel would swap datagrams on the shaped link, and best-effort readers would drop samples that arrive
/// after a newer one.
void run_on(int cpu) {
  cpu_set_t cpus;
  CPU_ZERO(&cpus);
  CPU_SET(cpu, &cpus);
  ::sched_setaffinity(0, sizeof cpus, &cpus);  // fails harmlessly on a machine with one CPU
}

class ShapedLinkTest : public testing::TestWithParam<Backend> {
 protected:
  void SetUp() override {
    if (!sft::test::isolation_refusal().empty()) GTEST_SKIP() << sft::test::isolation_refusal();
    const auto open = [] { return open_udp_transport({.backend = GetParam()}, test::make_pool()); };
    run_on(0);
    if (const std::string why = test::refusal_of(GetParam()); !why.empty()) GTEST_SKIP() << why;
    near_ = open().value();
    const unsigned net = GetParam() == Backend::io_uring ? 20 : 21;
    reader_.address.ip = test::on_another_host(net, [&] {
      run_on(1);
      far_ = open().value();
      run_on(0);
    });
    if (reader_.address.ip == 0) GTEST_SKIP() << "a second host cannot be had here";
    reader_.address.port = far_->addresses().at(0).port;
    reader_.address.receive_buffer_bytes = far_->addresses().at(0).receive_buffer_bytes;
    const std::string shape = "tc qdisc add dev to" + std::to_string(net) + " root tbf ";
    if (!test::run((shape + "rate 100mbit burst 70kb latency 1s").c_str()))
      GTEST_SKIP() << "links of a given rate cannot be made here";
  }
  Publisher::Reader reader(bool reliable) const { return {reader_.address, "*", reliable}; }

  std::unique_ptr<core::Network> near_, far_;
  Publisher::Reader reader_;
};

INSTANTIATE_TEST_SUITE_P(Backends, ShapedLinkTest, test::both_backends, test::backend_name);

/// Samples are published at fixed times, even if the link cannot carry all of them.
TEST_P(ShapedLinkTest, KeepsSmallSamplesFastWhileLargeOnesFillTheLink) {
  std::vector<std::unique_ptr<LargeTopic>> large;
  std::vector<std::unique_ptr<SmallTopic>> small;
  for (core::EndpointId id = 1; id <= 4; ++id)
    large.push_back(std::make_unique<LargeTopic>(*near_, *far_, reader(id % 2 == 0), id));
  for (core::EndpointId id = 5; id <= 6; ++id)
    small.push_back(std::make_unique<SmallTopic>(*near_, *far_, reader(id % 2 == 0), id));
  small[0]->publish();  // makes the kernel resolve the other host's address
  ASSERT_LT(small[0]->times().back(), 1s);

  // How long small samples take alone depends on what else the machine does. Large ones may add `bound`.
  StandstillMonitor monitor_alone(2);
  sft::test::Pace alone(pause, sft::test::Keeps::rate);
  for (int step = 0; step < duration_alone / pause; ++step, alone.await_turn()) {
    for (const auto& topic : small) topic->publish();
  }
  const Standstills standstills_alone = monitor_alone.end();
  std::vector<WatchedClock::duration> took_alone;
  for (const auto& topic : small) took_alone.push_back(percentile(topic->times(standstills_alone), 99));

  StandstillMonitor monitor(2);
  const auto began = WatchedClock::now();
  sft::test::Pace schedule(pause, sft::test::Keeps::rate);
  for (int step = 0; step < duration / pause; ++step, schedule.await_turn()) {
    for (const auto& topic : small) topic->publish();
    if (step % 2 == 0) large[static_cast<std::size_t>(step / 2 % 4)]->publish();
  }
  const auto ended = WatchedClock::now();
  std::size_t all = 0, least = SIZE_MAX;
  for (const auto& topic : large) {
    all += topic->came();
    least = std::min(least, topic->came());
  }
  const Standstills standstills = monitor.end();
  for (std::size_t i = 0; i < small.size(); ++i) {
    const auto times = small[i]->times(standstills);
    ASSERT_FALSE(times.empty()) << "the machine stood still all the time";
    const auto us = [&](std::size_t percent) { return percentile(times, percent) / 1us; };
    EXPECT_LT(us(99), (took_alone[i] + bound) / 1us)
        << "us; half of the samples took " << us(50) << " us, 90 of 100 took " << us(90)
        << " us; the machine stood still " << standstills.size() << " times; alone 99 of 100 took "
        << took_alone[i] / 1us << " us";
  }
  const std::chrono::duration<double> ran = duration - StandstillMonitor::within(standstills, began, ended);
  EXPECT_GE(static_cast<double>(all * LargeTopic::bytes), 0.7 * link_bytes_per_s * ran.count());
  EXPECT_GE(least, all / 4 / 4) << "each has its share";
}

}  // namespace
}  // namespace sft::udp
