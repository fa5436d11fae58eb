// One publisher and eight readers with two masks, each on a host of its own, on one bridge: what is on the
// wire.
#include <gtest/gtest.h>

#include <cstdio>

#include "tests/transports/udp/bridge_fixture.h"

namespace sft::udp {
namespace {

constexpr unsigned hosts = 8;
constexpr std::size_t samples_counted = 100;

class FanOutTest : public test::BridgeTest, public testing::WithParamInterface<bool> {
 protected:
  void SetUp() override {
    if (!sft::test::isolation_refusal().empty()) GTEST_SKIP() << sft::test::isolation_refusal();
    if (!make_bridge("") || !test::run("ip address add 10.20.0.1/24 dev bridge && ip link set bridge up"))
      GTEST_SKIP() << "no bridge can be made here";
    open_publisher();
    for (unsigned i = 0; i < hosts; ++i)
      ASSERT_TRUE(add_reader(i + 2, i % 2 == 0 ? "data" : "name", GetParam()));
  }

  double bytes_of_a_sample() {
    publish();
    const std::uint32_t before = test::traffic_of("bridge").sent;
    publish(samples_counted);
    return static_cast<double>(test::traffic_of("bridge").sent - before) / samples_counted;
  }
  /// Measures samples that go out before the first reader is offered a group, which takes a while. There are
  /// fewer of them where the machine is slow.
  double bytes_of_a_sample_without_groups() {
    publish();
    const std::uint32_t before = test::traffic_of("bridge").sent;
    std::uint32_t bytes = 0;
    std::size_t count = 0;
    for (; count < samples_counted && !HasFatalFailure(); ++count) {
      publish();
      if (some_join_groups()) break;
      bytes = test::traffic_of("bridge").sent - before;
    }
    EXPECT_GT(count, 0U);
    return static_cast<double>(bytes) / static_cast<double>(count);
  }
};

INSTANTIATE_TEST_SUITE_P(Each, FanOutTest, testing::Bool(),
                         [](const auto& param) { return param.param ? "Reliable" : "BestEffort"; });

TEST_P(FanOutTest, PutsBytesOnTheWireByMasksAndNotByReceivers) {
  serve(2);
  const double two_readers = bytes_of_a_sample();
  serve(hosts);
  const double alone = bytes_of_a_sample_without_groups();
  ASSERT_TRUE(publish_until([this] { return all_are_in_groups(); })) << publisher_->port().multicast(1);
  const double together = bytes_of_a_sample();
  std::printf("bytes for each sample: two readers %.0f; eight alone %.0f, by groups %.0f\n", two_readers,
              alone, together);
  RecordProperty("bytes_together", static_cast<int>(together));
  EXPECT_GT(alone, 3.5 * two_readers);
  EXPECT_LT(together, 1.05 * two_readers);
  EXPECT_TRUE(all_came());
}

}  // namespace
}  // namespace sft::udp
