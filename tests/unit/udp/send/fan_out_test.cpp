#include "udp_transport/send/fan_out.h"

#include <gtest/gtest.h>

#include <memory>
#include <utility>
#include <vector>

#include "tests/unit/udp/connections.h"
#include "tests/unit/udp/messages.h"

namespace sft::udp {
namespace {

using namespace detail;

using test::Image;

/// The test itself decides when deferred work is carried out.
class FanOutTest : public testing::Test {
 protected:
  explicit FanOutTest(const ResendLimits& limits = {})
      : tally_(std::make_shared<WriterTally>(0, std::int8_t{0}, limits)) {
    side_->max_sample_bytes = std::size_t{1} << 20;
  }

  /// Returns a table of routes with one mask. The sending thread sends the samples with this mask.
  std::shared_ptr<const RouteTable> routes(bool reliable) {
    auto table = std::make_shared<RouteTable>();
    Audience& audience =
        table->audiences.emplace_back(Audience{ProjectionPlan(type_.type(), FieldMask(all_)),
                                               nullptr,
                                               0,
                                               false,
                                               std::make_shared<WireMask>(WireMask{5, all_.hash(), {}}),
                                               {}});
    const auto to = side_->destinations.find({.ip = core::loopback_ipv4, .port = 1});
    if (reliable) channel_ = std::make_shared<Channel>(7, 1, to, tally_, 9);
    audience.lanes.push_back(std::make_shared<Lane>(to, 1000, tally_));
    audience.channels.push_back(channel_);
    return table;
  }
  /// Posts samples. Returns the number of samples that were dropped.
  std::size_t leave(std::size_t samples, std::size_t bytes, const std::shared_ptr<const RouteTable>& routes) {
    std::size_t dropped = 0;
    const Image image = test::make_image(bytes);
    for (std::uint64_t sequence = 1; sequence <= samples; ++sequence) {
      core::SampleHandle sample = memory_->take(test::sample_bytes(image, all_));
      test::fill(*sample, image, all_, 7, sequence);
      dropped += fan_out_.post({std::move(sample), routes, 0, 1}).dropped;
    }
    return dropped;
  }
  /// Sends the samples that wait in the channel. Returns their sequences.
  std::vector<std::uint32_t> send() {
    std::vector<std::uint32_t> sent;
    for (const auto size : {ResendWindow::Size::small, ResendWindow::Size::large}) {
      while (const auto piece = channel_->next(size)) {
        sent.push_back(piece->first.label.sequence);
        static_cast<void>(channel_->finished(*piece, std::chrono::steady_clock::now()));
      }
    }
    return sent;
  }
  Heartbeat heartbeat() {
    send();
    return channel_->look_after().heartbeat.value();
  }

  FanOut& fan_out() { return fan_out_; }
  std::uint64_t over_limit() const { return side_->over_limit; }
  void carry_out_all() {
    while (fan_out_.carry_out()) {
    }
  }

 private:
  const TypeSupport& type_ = test::type_support<Image>();
  const FieldMask all_ = test::fields<Image>("*");
  std::shared_ptr<core::BufferPool> memory_ = core::BufferPool::make(std::size_t{256} << 20);
  test::Connections connections_;
  std::shared_ptr<SendSide> side_ =
      std::make_shared<SendSide>(std::make_unique<test::NoSender>(connections_), DestinationLimits{});
  std::shared_ptr<WriterTally> tally_;
  FanOut fan_out_{{.id = 7, .type = &type_}, side_, tally_, JobPool::make()};
  std::shared_ptr<Channel> channel_;
};

TEST_F(FanOutTest, KeepsTheNewestFewOfWhatIsNotReliableAndCountsTheOthers) {
  EXPECT_EQ(leave(64, 100, routes(false)), 0U);
  EXPECT_EQ(over_limit(), 0U);
  EXPECT_EQ(leave(3, 100, routes(false)), 3U);
  EXPECT_EQ(over_limit(), 3U);
}

TEST_F(FanOutTest, KeepsOfWhatIsReliableAsMuchAsChannelsDo) {
  const auto reliable = routes(true);
  EXPECT_EQ(leave(100, 100, reliable), 0U);
  EXPECT_EQ(leave(20, 100'000, reliable), 0U);
  carry_out_all();
  EXPECT_TRUE(fan_out().done());
  const Heartbeat kept = heartbeat();
  EXPECT_EQ(kept.first, 1U);
  EXPECT_EQ(kept.end, 121U);
}

TEST_F(FanOutTest, SendsAFewSamplesInATurnHoweverManyWait) {
  EXPECT_EQ(leave(100, 100, routes(true)), 0U);
  int turns = 1;
  for (; fan_out().carry_out(); ++turns) EXPECT_FALSE(fan_out().done()) << "what is published now waits";
  EXPECT_GE(turns, 6);
  EXPECT_TRUE(fan_out().done());
  EXPECT_EQ(heartbeat().end, 101U);
}

TEST_F(FanOutTest, HasRoomForAsMuchAgainOnceItHasSentWhatWaited) {
  const auto reliable = routes(true);
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(leave(60, 1'000'000, reliable), 0U) << i;
    carry_out_all();
  }
}

TEST_F(FanOutTest, DropsTheOldestOfWhatIsReliableOnceItIsMoreThanChannelsKeep) {
  const std::size_t dropped = leave(100, 1'000'000, routes(true));
  EXPECT_GT(dropped, 0U);
  carry_out_all();
  EXPECT_TRUE(fan_out().done());
  const std::vector<std::uint32_t> sent = send();
  ASSERT_FALSE(sent.empty());
  for (std::size_t i = 0; i < sent.size(); ++i) EXPECT_EQ(sent[i], 101 - sent.size() + i);
  EXPECT_EQ(sent.size(), 100 - dropped);
}

TEST_F(FanOutTest, ReturnsHowManyHaveToGoForOneThatIsLarger) {
  const auto reliable = routes(true);
  EXPECT_EQ(leave(60, 1'000'000, reliable), 0U);
  const std::size_t dropped = leave(1, 20'000'000, reliable);
  EXPECT_GT(dropped, 1U);
  const core::DeliveryMeter counted{.tally = reliable->audiences.front().tally};
  EXPECT_EQ(counted.read().dropped, dropped);
}

class FanOutOfFewBytesTest : public FanOutTest {
 protected:
  FanOutOfFewBytesTest() : FanOutTest(ResendLimits::of_at_most(1'000'000)) {}
};

TEST_F(FanOutOfFewBytesTest, KeepsTheLatestThreeReliableSamplesHoweverLargeTheyAre) {
  const auto reliable = routes(true);
  EXPECT_EQ(leave(3, 900'000, reliable), 0U);
  EXPECT_EQ(leave(1, 900'000, reliable), 1U);
  carry_out_all();
  EXPECT_EQ(send().size(), 3U);
}

TEST_F(FanOutOfFewBytesTest, KeepsNoMoreReliableSamplesThanItsWriterAllows) {
  constexpr std::size_t samples = 100, bytes = 100'000;
  EXPECT_GE(leave(samples, bytes, routes(true)), samples - 1'000'000 / bytes);
}

}  // namespace
}  // namespace sft::udp
