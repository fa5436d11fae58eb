#include "udp_transport/reliable/channel_directory.h"

#include <gtest/gtest.h>

#include <memory>

#include "tests/unit/udp/connections.h"
#include "udp_transport/flow/destination_directory.h"

namespace sft::udp {
namespace {

class ChannelDirectoryTest : public testing::Test {
 protected:
  std::shared_ptr<Destination> to(std::uint16_t port) { return destinations.find({.ip = 1, .port = port}); }

  test::Connections connections;
  DestinationDirectory destinations{{}, connections.connect()};
  ChannelRegistry registry;
  ChannelDirectory channels{7, std::make_shared<WriterTally>(), registry, 5000};
};

TEST_F(ChannelDirectoryTest, KeepsAChannelAsLongAsOneOfItsReadersStays) {
  const auto there = to(1);
  const auto channel = channels.find(there, {1, 2});
  EXPECT_EQ(channels.find(there, {2, 3}), channel);
  EXPECT_EQ(channels.find(there, {3}), channel);
  EXPECT_FALSE(channel->closed());
}

TEST_F(ChannelDirectoryTest, GivesOthersAChannelOfTheirOwnWithAGreaterNumber) {
  const auto there = to(1);
  const auto channel = channels.find(there, {1});
  const auto next = channels.find(there, {2});
  EXPECT_NE(next, channel);
  EXPECT_GT(static_cast<std::int32_t>(next->number() - channel->number()), 0);
  EXPECT_TRUE(channel->closed());
}

TEST_F(ChannelDirectoryTest, NumbersThemSoThatNobodyElseCanGuessAndTheReceiverCanTellTheNewer) {
  std::uint32_t before = channels.find(to(1), {1})->number();
  EXPECT_GT(before - channels.find(to(2), {2})->number() + 1000, 2000U) << "whoever knows one knows no other";
  for (core::EndpointId reader = 3; reader < 20; ++reader) {  // The destination is removed in between.
    channels.keep_to({});
    const std::uint32_t number = channels.find(to(1), {reader})->number();
    EXPECT_GT(static_cast<std::int32_t>(number - before), 0);
    EXPECT_LT(number - before, 1000U);
    before = number;
  }
}

TEST_F(ChannelDirectoryTest, BeginsAnotherOneWhereAcksAreOfWhatWasNeverSent) {
  const auto there = to(1);
  const auto channel = channels.find(there, {1});
  const auto ack = [&](std::uint64_t next) {
    static_cast<void>(channel->hear({.writer = 7, .channel = channel->number(), .next = next}));
  };
  ack(2);
  ack(1);
  ack(std::uint64_t{1} << 62);
  EXPECT_FALSE(channel->closed()) << "one by itself can be a flipped bit";
  EXPECT_FALSE(channels.any_channel_failed());
  ack(2);
  EXPECT_TRUE(channel->closed());
  EXPECT_TRUE(channels.any_channel_failed());
  const auto next = channels.find(there, {1});
  EXPECT_NE(next, channel);
  EXPECT_FALSE(next->closed());
  EXPECT_FALSE(channels.any_channel_failed());
}

TEST_F(ChannelDirectoryTest, EndsChannelsToWhereNobodyIsServedReliablyAnyMore) {
  const auto one = to(1), other = to(2);
  const auto channel = channels.find(one, {1});
  const auto stays = channels.find(other, {2});
  channels.keep_to({{other.get(), {2}}});
  EXPECT_TRUE(channel->closed());
  EXPECT_FALSE(stays->closed());
  EXPECT_NE(channels.find(one, {1}), channel) << "it begins anew";
}

TEST_F(ChannelDirectoryTest, TellsOnceThatChannelsWereClosedOrHaveEnded) {
  const auto there = to(1);
  const auto channel = channels.find(there, {1});
  channels.keep_to({{there.get(), {1}}});
  EXPECT_FALSE(channels.take_closed());
  const auto next = channels.find(there, {2});
  EXPECT_TRUE(channels.take_closed());
  EXPECT_FALSE(channels.take_closed());
  channels.keep_to({});
  EXPECT_TRUE(channels.take_closed());
  channels.keep_to({});
  EXPECT_FALSE(channels.take_closed()) << "it has ended already";
}

TEST_F(ChannelDirectoryTest, FindsTheChannelOfAnAckWhileItIsHeld) {
  const auto there = to(1);
  auto channel = channels.find(there, {1});
  EXPECT_EQ(registry.find(7, channel->number()), channel);
  EXPECT_EQ(registry.find(7, channel->number() + 1), nullptr);
  EXPECT_EQ(registry.find(8, channel->number()), nullptr);
  const std::uint32_t number = channel->number();
  channel.reset();
  EXPECT_EQ(registry.find(7, number), nullptr);
}

}  // namespace
}  // namespace sft::udp
