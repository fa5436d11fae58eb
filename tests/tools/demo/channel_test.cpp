// Tests of the messages between the demo and its processes, and of reading the counters of an interface.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

#include "tools/demo/channel.h"
#include "tools/demo/reports.h"
#include "tools/hosts/interface_counters.h"

namespace sft::demo {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

class ChannelTest : public testing::Test {
 protected:
  ChannelTest() : ends_(Channel::make_pair().value()) {}

  Result<nlohmann::json> ask(tool::Stop* stop = nullptr) {
    return demo::ask(ends_.first, "detector", "", 60s, stop);
  }

  std::pair<Channel, Channel> ends_;
};

TEST_F(ChannelTest, CarriesReportsUnchanged) {
  SubscriberReport sent;
  sent.fields = {"header.stamp.sec", "data"};
  sent.counts.samples = 1ULL << 60;
  sent.p50_us = 1.25;
  sent.learnt = Counts{3, 4, 5};
  ASSERT_TRUE(ends_.second.send(sent));
  const auto received = ask();
  ASSERT_TRUE(received) << received.error().message;
  EXPECT_EQ(nlohmann::json(received->get<SubscriberReport>()), nlohmann::json(sent));
}

TEST_F(ChannelTest, KeepsMessagesApart) {
  ends_.first.send({1});
  ends_.first.send({2});
  EXPECT_EQ(ends_.second.receive(), nlohmann::json({1}));
  EXPECT_EQ(ends_.second.receive(), nlohmann::json({2}));
}

TEST_F(ChannelTest, TellsThatTheOtherSideIsGone) {
  ends_.second = Channel::make_pair().value().first;
  EXPECT_FALSE(ends_.first.send({1}));
  EXPECT_FALSE(ends_.first.receive());
  EXPECT_THAT(ask().error().message, HasSubstr("the process of the detector has ended unexpectedly"));
}

TEST_F(ChannelTest, WaitsNoLongerThanItsDeadline) {
  EXPECT_FALSE(ends_.first.readable_before(Clock::now() + 1ms));
  EXPECT_FALSE(ends_.first.readable_before(Clock::now() - 1ms));
}

TEST_F(ChannelTest, GivesUpWaitingForAnAnswerWhenTheUserAsksToStop) {
  tool::Stop stop;
  stop.request();
  EXPECT_THAT(ask(&stop).error().message, HasSubstr("stopped before anything was published"));
}

TEST_F(ChannelTest, BringsTheErrorOfARoleThatCannotGoOn) {
  std::thread role([this] { refuse(ends_.second, {Errc::unavailable, "no network; switch it on"}); });
  EXPECT_THAT(ask().error().message, HasSubstr("detector: no network; switch it on"));
  role.join();
}

constexpr const char* proc_net_dev =
    "Inter-|   Receive                                                |  Transmit\n"
    " face |bytes    packets errs drop fifo frame compressed multicast|bytes    packets errs drop fifo colls "
    "carrier\n"
    "    lo:     100       2    0    0    0     0          0         0      100       2    0    0    0     0 "
    "      0\n"
    "  eth0: 18446744073709551615 7 0 0 0 0 0 3 4096 9 0 0 0 0 0\n"
    "veth_eth0: 1 1 0 0 0 0 0 0 2 2 0 0 0 0 0\n";

TEST(Counters, AreThoseOfTheInterface) {
  const auto eth0 = hosts::parse_interface_bytes(proc_net_dev, "eth0");
  ASSERT_TRUE(eth0);
  EXPECT_EQ(eth0->received, 18446744073709551615ULL);
  EXPECT_EQ(eth0->sent, 4096U);
  const auto lo = hosts::parse_interface_bytes(proc_net_dev, "lo");
  ASSERT_TRUE(lo);
  EXPECT_EQ(lo->received, 100U);
}

TEST(Counters, OfAnInterfaceThatIsNotThereAreNone) {
  EXPECT_FALSE(hosts::parse_interface_bytes(proc_net_dev, "eth"));
  EXPECT_FALSE(hosts::parse_interface_bytes(proc_net_dev, "eth1"));
  EXPECT_FALSE(hosts::parse_interface_bytes("", "eth0"));
}

}  // namespace
}  // namespace sft::demo
