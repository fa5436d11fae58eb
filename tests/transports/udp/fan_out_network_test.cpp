// The traffic of one publisher and eight readers with two masks on one bridge. Each reader is on a host of
// its own.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <numeric>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "tests/transports/udp/bridge_fixture.h"
#include "tests/transports/udp/sample_tap.h"
#include "udp_transport/multicast/multicast_plan.h"
#include "udp_transport/multicast/probe_schedule.h"
#include "udp_transport/outgoing/resend_limits.h"
#include "udp_transport/routing/settling_times.h"
#include "udp_transport/wire/datagram.h"

namespace sft::udp {
namespace {

constexpr unsigned hosts = 8;
constexpr std::size_t samples_counted = 100;

class ManyHostsTest : public test::BridgeTest {
 protected:
  void SetUp() override {
    if (!sft::test::isolation_refusal().empty()) GTEST_SKIP() << sft::test::isolation_refusal();
    if (!make_bridge("") || !test::run("ip address add 10.20.0.1/24 dev bridge && ip link set bridge up"))
      GTEST_SKIP() << "no bridge can be made here";
  }
};

class FanOutTest : public ManyHostsTest, public testing::WithParamInterface<bool> {
 protected:
  void make_hosts(const UdpOptions& options) {
    open_publisher(options);
    for (unsigned i = 0; i < hosts; ++i)
      ASSERT_TRUE(add_reader(i + 2, i % 2 == 0 ? "data" : "name", GetParam()));
  }

  double bytes_of_a_sample() {
    publish();
    const std::uint32_t before = test::traffic_of("bridge").sent;
    publish(samples_counted);
    return static_cast<double>(test::traffic_of("bridge").sent - before) / samples_counted;
  }
};

INSTANTIATE_TEST_SUITE_P(Each, FanOutTest, testing::Bool(),
                         [](const auto& param) { return param.param ? "Reliable" : "BestEffort"; });

TEST_P(FanOutTest, PutsBytesOnTheWireByMasksAndNotByReceivers) {
  make_hosts({});
  serve(2);
  const double two_readers = bytes_of_a_sample();
  serve(hosts);
  const auto gathered = std::chrono::steady_clock::now() + SettlingTimes::gathering;
  ASSERT_TRUE(publish_until([&] { return std::chrono::steady_clock::now() >= gathered; }));
  const std::uint32_t before = published_;
  ASSERT_TRUE(publish_until([this] { return all_are_in_groups(); })) << publisher_->port().multicast(1);
  const std::uint32_t until_settled = published_ - before;
  const double together = bytes_of_a_sample();
  std::printf(
      "bytes for each sample: two readers %.0f; eight by groups %.0f, settled after %u samples more\n",
      two_readers, together, until_settled);
  RecordProperty("bytes_together", static_cast<int>(together));
  EXPECT_LT(together, 1.05 * two_readers);
  EXPECT_TRUE(all_came());
}

/// The first sample is sent to each member alone, because its size was not known before. One more sample is
/// sent both alone and to the group, because a reliable member learns its place in the group from this
/// sample. Each other sample is sent either alone or to the group.
TEST_P(FanOutTest, SendsTheNextSampleToGroupsAloneOnceTheirMembersWereProbed) {
  make_hosts({});
  serve(hosts);
  const auto gathered = std::chrono::steady_clock::now() + SettlingTimes::gathering;
  ASSERT_TRUE(test::eventually([&] { return std::chrono::steady_clock::now() >= gathered; }));
  publish(GetParam() ? 2 : 1);
  EXPECT_LE(writer_->next_poll(), std::chrono::steady_clock::now() + ProbeSchedule::first_pause);
  ASSERT_TRUE(test::eventually([this] {
    const auto now = std::chrono::steady_clock::now();
    writer_->poll(now);
    if (all_are_in_groups()) return true;
    const bool probes_have_ended = writer_->next_poll() == decltype(now)::max();
    // The probes ended because the machine was too busy to answer the probes in time.
    if (probes_have_ended) publish();
    return false;
  })) << publisher_->port().multicast(1);
  test::SampleTap tap("bridge");
  ASSERT_TRUE(tap.is_open());
  ASSERT_TRUE(all_came());
  (void)tap.bytes();
  const auto bytes_of_one = [&] {
    publish();
    EXPECT_TRUE(all_came());
    return static_cast<double>(tap.bytes());
  };
  const double next = bytes_of_one();
  EXPECT_LE(next, 1.05 * (data_bytes + name_bytes)) << "each field once";
  double others = 0;
  for (std::size_t i = 0; i < samples_counted; ++i) others += bytes_of_one();
  EXPECT_LE(next, 1.05 * others / samples_counted);
}

TEST_P(FanOutTest, PutsThemThereByReceiversWhereMulticastIsOff) {
  make_hosts({.multicast = Multicast::off});
  serve(2);
  const double two_readers = bytes_of_a_sample();
  serve(hosts);
  EXPECT_GT(bytes_of_a_sample(), 3.5 * two_readers);
}

class WaitingFanOutTest : public ManyHostsTest {
 protected:
  void SetUp() override {
    ManyHostsTest::SetUp();
    if (IsSkipped()) return;
    open_publisher();
    publisher_ = std::make_unique<test::Publisher>(*writer_, test::Publisher::usual_id, 0, nullptr, false,
                                                   test::hang_timeout);
  }
};

/// The publisher may wait for a reader even if the reader shares a group with others.
TEST_F(WaitingFanOutTest, LosesNothingToAMemberOfAGroupThatIsCutOffForAWhile) {
  constexpr std::uint32_t kept_most = ResendLimits{}.samples;
  constexpr std::uint32_t samples = kept_most + 2000;
  for (const unsigned number : {2, 3, 4}) ASSERT_TRUE(add_reader(number, "height", true));
  serve(3);
  ASSERT_TRUE(publish_until([this] { return all_are_in_groups(); })) << publisher_->port().multicast(1);
  ASSERT_TRUE(all_came());
  ASSERT_TRUE(test::run("ip link set port3 down"));

  std::atomic<std::uint32_t> sent{0};
  std::atomic<std::size_t> dropped{0};
  std::thread publishing([&] {
    for (; sent < samples; ++sent) {
      if (publisher_->publish(test::make_image(1, sent)) != core::SendStatus::sent) ++dropped;
    }
  });
  EXPECT_TRUE(test::eventually([&] { return sent >= kept_most / 2; }));
  EXPECT_FALSE(test::eventually([&] { return sent > kept_most; }, std::chrono::milliseconds(300)))
      << "it has to wait by then";
  EXPECT_TRUE(test::run("ip link set port3 up"));
  publishing.join();
  published_ += samples;
  EXPECT_TRUE(all_came());
  EXPECT_EQ(dropped, 0U);
}

struct Masks {
  unsigned readers;
  bool reliable;
};
/// Each reader has its own mask. There are several readers on each of the eight hosts.
class ManyMasksTest : public ManyHostsTest, public testing::WithParamInterface<Masks> {
 protected:
  void SetUp() override {
    ManyHostsTest::SetUp();
    if (IsSkipped()) return;
    open_publisher();
    for (unsigned host = 0; host < hosts; ++host) {
      std::vector<std::string> masks;
      for (unsigned i = host; i < GetParam().readers; i += hosts) masks.push_back(mask(i));
      ASSERT_TRUE(add_readers(host + 2, masks, GetParam().reliable));
    }
  }

  /// Returns the average bytes per sample. A reliable reader that acknowledges late gets heartbeats. On a
  /// busy machine heartbeats follow many samples, so with reliable readers only the smaller half of the
  /// samples counts.
  double bytes_of_a_sample() {
    std::vector<std::uint32_t> each;
    std::uint32_t before = test::traffic_of("bridge").sent;
    for (std::size_t i = 0; i < samples_counted; ++i) {
      publish();
      EXPECT_TRUE(all_came());
      const std::uint32_t after = test::traffic_of("bridge").sent;
      each.push_back(after - std::exchange(before, after));
    }
    std::ranges::sort(each);
    if (GetParam().reliable) each.resize(samples_counted / 2);
    return std::accumulate(each.begin(), each.end(), 0.) / static_cast<double>(each.size());
  }

  /// Returns one of 64 masks, because the image has six fields. The first 32 masks include the data.
  static std::string mask(unsigned number) {
    std::string mask = number < 32 ? "data" : "";
    for (const char* field : {", stamp.sec", ", stamp.nanosec", ", name", ", height", ", width"}) {
      if (number % 2 == 1) mask += field;
      number /= 2;
    }
    return mask;
  }
};

INSTANTIATE_TEST_SUITE_P(Each, ManyMasksTest,
                         testing::Values(Masks{16, false}, Masks{16, true}, Masks{64, true}),
                         [](const auto& param) {
                           return (param.param.reliable ? "Reliable" : "BestEffort") +
                                  std::to_string(param.param.readers);
                         });

TEST_P(ManyMasksTest, CostNoMoreThanEverythingToEverybody) {
  serve(hosts_.size());
  constexpr std::size_t other_fields = 4 + 4 + (4 + name_bytes + 1) + 3 + 4 + 4 + 4;
  const double whole = wire_bytes(data_bytes + other_fields, datagram_bytes_max, PlaceMark::in_group);
  // Readers that request little may stay out of groups.
  const auto is_shared = [&] {
    const std::uint32_t before = test::traffic_of("bridge").sent;
    publish();
    return all_came() && test::traffic_of("bridge").sent - before <= 1.05 * whole;
  };
  ASSERT_TRUE(test::eventually(is_shared)) << publisher_->port().multicast(1);
  const double bytes = bytes_of_a_sample();
  std::printf("bytes for each sample: %.0f; the whole image by multicast: %.0f\n", bytes, whole);
  RecordProperty("bytes", static_cast<int>(bytes));
  EXPECT_LE(bytes, 1.05 * whole);
  EXPECT_TRUE(all_came());
}

}  // namespace
}  // namespace sft::udp
