// These tests check large samples that are sent from the program's memory before they are copied.
#include "udp_transport/send/variant_sender.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <vector>

#include "tests/support/parse_datagram.h"
#include "tests/unit/udp/connections.h"
#include "tests/unit/udp/jobs.h"
#include "tests/unit/udp/messages.h"

namespace sft::udp {
namespace {

using namespace detail;

using test::Bytes;
using test::Image;

constexpr std::size_t sent_image_bytes = 500'000;

class SendsAhead : public testing::Test {
 protected:
  SendsAhead() { side_->max_sample_bytes = std::size_t{1} << 20; }

  enum class Delivery : std::uint8_t { best_effort, reliable };
  void route(Delivery delivery) {
    to_->bulk();  // makes the connection that earlier large samples would have made
    to_->set_receive_buffer(8 << 20);
    audience_.lanes.push_back(std::make_shared<Lane>(to_, 1000, tally_));
    if (delivery == Delivery::reliable) channel_ = std::make_shared<Channel>(7, 1, to_, tally_, 9);
    audience_.channels.push_back(channel_);
  }
  /// Does what Publisher::publish() does until the message is no longer used. Returns the number of missed
  /// samples.
  std::size_t publish() {
    const Image image = test::make_image(sent_image_bytes);
    sample_ = memory_->take(test::sample_bytes(image, all_));
    std::memset(sample_->data, 0, sample_->capacity);
    test::fill(*sample_, image, all_, 7, ++sequence_, &postponed_);
    sample_->postponed = &postponed_;
    const std::size_t missed = sender_.send(audience_, sample_);
    expected_ = test::encoded_body(image, all_);
    left_out_ = sample_->postponed != nullptr && !postponed_.empty();
    sample_->postponed = nullptr;
    postponed_.clear();
    return missed;
  }
  /// Returns the delivery counts of the audience.
  core::Delivered counted() const { return core::DeliveryMeter{.tally = audience_.tally}.read().delivered(); }
  bool is_copied() const { return test::body_of(*sample_) == expected_; }
  void acknowledge_all() {
    static_cast<void>(channel_->hear({.writer = 7, .channel = 1, .next = sequence_ + 1}));
  }
  /// Returns the body, put together from the datagrams that were sent. Bytes that were not sent are zero.
  Bytes sent_body() const {
    Bytes body(expected_.size());
    for (const Bytes& bytes : connections_.sent()) {
      const Datagram datagram = parse(bytes).value();
      std::ranges::copy(datagram.payload, body.begin() + datagram.offset);
    }
    return body;
  }

  const TypeSupport& type_ = test::type_support<Image>();
  const FieldMask all_ = test::fields<Image>("*");
  std::shared_ptr<core::BufferPool> memory_ = core::BufferPool::make(std::size_t{64} << 20);
  test::Connections connections_;
  std::shared_ptr<SendSide> side_ =
      std::make_shared<SendSide>(std::make_unique<test::NoSender>(connections_), DestinationLimits{});
  std::shared_ptr<WriterTally> tally_ = std::make_shared<WriterTally>();
  std::shared_ptr<Destination> to_ = side_->destinations.find({.ip = core::loopback_ipv4, .port = 1});
  Audience audience_{ProjectionPlan(type_.type(), FieldMask(all_)),
                     nullptr,
                     0,
                     false,
                     std::make_shared<WireMask>(WireMask{5, all_.hash(), {}}),
                     {}};
  std::shared_ptr<Channel> channel_;
  VariantSender sender_{{.id = 7, .type = &type_}, side_, tally_, JobPool::make()};
  PostponedCopies postponed_;
  core::SampleHandle sample_;
  Bytes expected_;
  bool left_out_ = false;
  std::uint64_t sequence_ = 0;
};

TEST_F(SendsAhead, IsNotCopiedWhereAllOfItHasLeftAndNobodyAsksAgain) {
  route(Delivery::best_effort);
  EXPECT_EQ(publish(), 0U);
  EXPECT_EQ(sent_body(), expected_);
  EXPECT_TRUE(left_out_);
  EXPECT_TRUE(audience_.lanes.front()->idle());
  EXPECT_EQ(counted(), (core::Delivered{.sent = 1, .bytes = expected_.size()}));
}

TEST_F(SendsAhead, LeavesNothingOutOfTheNextOneThatIsQueued) {
  route(Delivery::best_effort);
  EXPECT_EQ(publish(), 0U);
  // The audience gets a second lane. Samples for two lanes cannot be sent before the copy is made.
  route(Delivery::best_effort);
  EXPECT_EQ(publish(), 0U);
  EXPECT_TRUE(is_copied());
  for (const std::shared_ptr<Lane>& lane : audience_.lanes) {
    const Job* const job = lane->next();
    ASSERT_NE(job, nullptr);
    EXPECT_EQ(job->sent_bytes, 0U);
  }
}

TEST_F(SendsAhead, LeavesACopyToTheSendingThreadWhereSendBuffersAreFull) {
  route(Delivery::best_effort);
  connections_.take_batches(2);
  EXPECT_EQ(publish(), 0U);
  EXPECT_FALSE(left_out_);
  const Job* const rest = audience_.lanes.front()->next();
  ASSERT_NE(rest, nullptr);
  EXPECT_GT(rest->sent_bytes, 100'000U);
  EXPECT_EQ(to_->window().position(), audience_.lanes.front()->behind());
  for (const Bytes& datagram : test::cut(rest->body(), to_->path().datagram_bytes())) {
    const Datagram d = parse(datagram).value();
    EXPECT_TRUE(std::ranges::equal(d.payload, std::span(expected_).subspan(d.offset, d.payload.size())));
  }
}

TEST_F(SendsAhead, IsCopiedBehindWhereItMayBeAskedForAgain) {
  route(Delivery::reliable);
  EXPECT_EQ(publish(), 0U);
  EXPECT_EQ(sent_body(), expected_);
  EXPECT_FALSE(left_out_);
  EXPECT_TRUE(is_copied());
  EXPECT_FALSE(channel_->next(ResendWindow::Size::large)) << "all has left";
  ASSERT_TRUE(channel_->keeps(1));
  Ack ack{.writer = 7, .channel = 1, .next = 1};
  ack.missing[ack.missing_count++] = {1, 100'000, 200'000};
  static_cast<void>(channel_->hear(ack));
  const auto repair = channel_->next(ResendWindow::Size::large);
  ASSERT_TRUE(repair);
  EXPECT_TRUE(repair->is_repair);
}

TEST_F(SendsAhead, GoesOnInTheSendingThreadFromWhereItHadNoRoom) {
  route(Delivery::reliable);
  connections_.take_batches(3);
  EXPECT_EQ(publish(), 0U);
  EXPECT_TRUE(is_copied());
  connections_.take_batches(SIZE_MAX);
  const auto rest = channel_->next(ResendWindow::Size::large);
  ASSERT_TRUE(rest);
  EXPECT_GT(rest->range.begin, 150'000U);
  Fragmenter fragments(rest->body(), to_->path().datagram_bytes(), rest->range);
  for (Batch batch; !fragments.done();) {
    fragments.next(batch);
    const OutgoingBatch next{batch.parts(), batch.segment_bytes()};
    to_->bulk().try_send({&next, 1});
  }
  EXPECT_EQ(sent_body(), expected_);
}

TEST_F(SendsAhead, DoesNotOvertakeWhatWaits) {
  route(Delivery::reliable);
  connections_.take_batches(3);
  publish();
  connections_.take_batches(SIZE_MAX);
  const std::size_t before = connections_.sent().size();
  publish();
  EXPECT_TRUE(is_copied());
  EXPECT_EQ(connections_.sent().size(), before);
  EXPECT_EQ(channel_->next(ResendWindow::Size::large)->ordinal, 1U);
  EXPECT_EQ(channel_->next(ResendWindow::Size::large)->ordinal, 2U);
}

TEST_F(SendsAhead, DoesNotOvertakeALargeSampleThatWaitsUnderAnotherMask) {
  route(Delivery::best_effort);
  const auto jobs = JobPool::make();
  Lane former(to_, 1000, tally_);
  former.post(test::make_job(*jobs, 1, sent_image_bytes));
  EXPECT_EQ(publish(), 0U);
  EXPECT_TRUE(connections_.sent().empty());
  EXPECT_TRUE(is_copied());
  EXPECT_FALSE(audience_.lanes.front()->idle()) << "the sending thread sends it, in order";
}

TEST_F(SendsAhead, IsNotCopiedOnceItIsAcknowledged) {
  route(Delivery::reliable);
  connections_.behind_each([this] { acknowledge_all(); });
  EXPECT_EQ(publish(), 0U);
  EXPECT_TRUE(left_out_);
  EXPECT_FALSE(channel_->keeps(1));
}

}  // namespace
}  // namespace sft::udp
