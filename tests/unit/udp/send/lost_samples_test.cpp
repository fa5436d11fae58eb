// These tests check that neither lost samples nor their bytes count as sent. The samples are lost before
// they are sent to a destination.
#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string_view>

#include "core/seam/delivery.h"
#include "tests/unit/udp/connections.h"
#include "tests/unit/udp/messages.h"
#include "udp_transport/send/variant_sender.h"

namespace sft::udp {
namespace {

using core::Delivered;
using core::DeliveryBook;
using test::Image;

/// A publisher and one reader. No datagram can be sent to that reader.
class LostSamplesTest : public testing::Test {
 protected:
  static constexpr std::size_t lane_depth = 3;
  static constexpr core::EndpointId reader = 1;

  enum class Delivery : std::uint8_t { best_effort, reliable };
  void serve(Delivery delivery, std::string_view asked, std::size_t data_bytes = 10,
             Lane::Start start = Lane::Start::open) {
    side_->max_sample_bytes = std::size_t{1} << 20;
    side_->pool = memory_;
    connections_.take_batches(0);
    image_ = test::make_image(data_bytes);
    const Selection selection = test::selection_of<Image>(asked);
    audience_.emplace(detail::ProjectionPlan(type_, selection), nullptr, 0, false,
                      std::make_shared<WireMask>(WireMask{5, selection.hash(), {}}));
    audience_->packs = true;
    lane_ = std::make_shared<Lane>(to_, lane_depth, tally_, start);
    audience_->lanes.push_back(lane_);
    const bool reliable = delivery == Delivery::reliable;
    audience_->channels.push_back(reliable ? std::make_shared<Channel>(7, 1, to_, tally_, 9) : nullptr);
    const DeliveryBook::Page page{{reader, {.tally = audience_->tally, .losses = lane_->losses()}}};
    book_.enter(page);
    book_.turn_to(DeliveryBook::Origin::network, page);
  }
  core::SampleHandle make() {
    core::SampleHandle sample = memory_->take(test::sample_bytes(image_, all_));
    test::fill(*sample, image_, all_, 7, ++sequence_);
    // The same stamp for all, because samples that are published together have one stamp.
    sample->source_stamp_ns = 5;
    sample->whole_bytes = sample->header().body_bytes;
    whole_bytes_ = sample->whole_bytes;
    return sample;
  }
  void publish(std::size_t samples) {
    for (std::size_t i = 0; i < samples; ++i) sender_.send(*audience_, make());
  }
  void publish_together(std::size_t samples) {
    for (std::size_t i = 0; i < samples; ++i)
      ASSERT_EQ(sender_.hold(*audience_, make()), VariantSender::Hold::held);
    sender_.flush();
  }
  /// Returns the expected counts of the reader. Samples that still wait count as sent.
  Delivered counts(std::uint64_t sent, std::uint64_t dropped, std::uint64_t body_bytes) const {
    return {.sent = sent,
            .dropped = dropped,
            .bytes = sent * body_bytes,
            .bytes_saved = sent * (whole_bytes_ - body_bytes)};
  }
  Delivered counted() const { return book_.of(reader); }

  const TypeSupport& type_ = test::type_support<Image>();
  const FieldMask all_ = test::fields<Image>("*");
  std::shared_ptr<core::BufferPool> memory_ = core::BufferPool::make(std::size_t{64} << 20);
  test::Connections connections_;
  std::shared_ptr<SendSide> side_ =
      std::make_shared<SendSide>(std::make_unique<test::NoSender>(connections_), DestinationLimits{});
  std::shared_ptr<WriterTally> tally_ = std::make_shared<WriterTally>();
  std::shared_ptr<Destination> to_ = side_->destinations.find({.ip = core::loopback_ipv4, .port = 1});
  Image image_;
  std::optional<Audience> audience_;
  std::shared_ptr<Lane> lane_;
  VariantSender sender_{{.id = 7, .type = &type_}, side_, tally_, JobPool::make()};
  DeliveryBook book_;
  std::uint64_t sequence_ = 0;
  std::uint64_t whole_bytes_ = 0;
};

constexpr std::size_t height_bytes = 4;  // the size of a body with the field `height` alone

TEST_F(LostSamplesTest, SmallOnesThatAFullQueueDrops) {
  serve(Delivery::best_effort, "height");
  publish(10);
  EXPECT_EQ(counted(), counts(lane_depth, 10 - lane_depth, height_bytes));
  EXPECT_EQ(side_->over_limit, 10 - lane_depth);
}

TEST_F(LostSamplesTest, ThoseThatTheSystemRefuses) {
  serve(Delivery::best_effort, "height");
  connections_.take_batches(2, SendOutcome::failed);
  publish(5);
  EXPECT_EQ(counted(), counts(2, 3, height_bytes));
  EXPECT_EQ(side_->over_limit, 0U);
}

TEST_F(LostSamplesTest, ThoseThatAreTooLarge) {
  serve(Delivery::best_effort, "data", 50'000);
  side_->max_sample_bytes = 20'000;
  publish(5);
  EXPECT_EQ(counted(), counts(0, 5, 0));
  EXPECT_EQ(side_->over_limit, 5U);
}

TEST_F(LostSamplesTest, LargeOnesThatAFullQueueDrops) {
  serve(Delivery::best_effort, "data", 50'000);
  publish(10);
  EXPECT_EQ(counted(), counts(lane_depth, 10 - lane_depth, 4 + 50'000));
}

TEST_F(LostSamplesTest, PartsThatAFullQueueDrops) {
  serve(Delivery::best_effort, "data[::2]", 50'000);
  publish(10);
  EXPECT_EQ(counted(), counts(lane_depth, 10 - lane_depth, 4 + 25'000));
}

TEST_F(LostSamplesTest, SeveralThatHaveToGoForOneLargeOne) {
  // Up to 1 MiB may wait until the history is sent.
  serve(Delivery::best_effort, "data", 5'000, Lane::Start::held);
  publish(100);
  EXPECT_EQ(counted().dropped, 0U);
  image_ = test::make_image(900'000);
  publish(1);
  EXPECT_GT(counted().dropped, 1U);
  EXPECT_EQ(counted().sent + counted().dropped, 101U);
  EXPECT_EQ(counted().bytes, (counted().sent - 1) * (4 + 5'000) + 4 + 900'000);
  EXPECT_EQ(side_->over_limit, counted().dropped);
}

TEST_F(LostSamplesTest, ThoseThatTheSendingThreadLoses) {
  serve(Delivery::best_effort, "height");
  publish(2);
  ASSERT_NE(lane_->next(), nullptr);
  lane_->lose_current();
  ASSERT_NE(lane_->next(), nullptr);
  EXPECT_EQ(counted(), counts(1, 1, height_bytes));
  EXPECT_EQ(tally_->dropped, 1U);
}

TEST_F(LostSamplesTest, AllOfAPackThatTheSendingThreadLoses) {
  serve(Delivery::best_effort, "height");
  publish_together(5);
  ASSERT_NE(lane_->next(), nullptr);
  ASSERT_EQ(lane_->current()->samples(), 5U);
  lane_->lose_current();
  EXPECT_EQ(counted(), counts(0, 5, height_bytes));
  EXPECT_EQ(tally_->dropped, 5U);
}

TEST_F(LostSamplesTest, ThoseThatAFullChannelDrops) {
  serve(Delivery::reliable, "height");
  constexpr std::size_t dropped = 20;
  // A part of the first sample was sent. This sample may have arrived, so it counts as sent.
  publish(1 + dropped + ResendLimits{}.samples);
  EXPECT_EQ(counted(), counts(1 + ResendLimits{}.samples, dropped, height_bytes));
  EXPECT_EQ(side_->over_limit, dropped);
}

TEST_F(LostSamplesTest, ThosePublishedTogetherOfWhichAFullChannelDropsSome) {
  serve(Delivery::reliable, "height");
  constexpr std::size_t together = 1000, packs = 6;
  for (std::size_t i = 0; i < packs; ++i) publish_together(together);
  constexpr std::size_t dropped = (packs - 1) * together - ResendLimits{}.samples;
  EXPECT_EQ(counted(), counts(packs * together - dropped, dropped, height_bytes));
  EXPECT_EQ(side_->over_limit, dropped);
}

}  // namespace
}  // namespace sft::udp
