// Counts the allocations by operator new of the process while each sample is queued under many masks. Nothing
// is sent, so each run of the test uses the same jobs for the same masks.
#include <gtest/gtest.h>

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "tests/support/process_allocations.h"
#include "tests/unit/udp/connections.h"
#include "tests/unit/udp/messages.h"
#include "tests/unit/udp/send/sending.h"
#include "udp_transport/send/variant_sender.h"

namespace sft::udp {
namespace {

using test::fields;
using test::Image;

constexpr std::size_t masks = 64, lane_depth = 2;

/// Returns the number of allocations during one call.
template <class Act>
std::uint64_t allocations_of(const Act& act) {
  sft::test::note_allocations();
  const std::uint64_t before = sft::test::process_allocations();
  act();
  const std::uint64_t allocations = sft::test::process_allocations() - before;
  if (allocations != 0) sft::test::print_allocations();
  return allocations;
}

/// Returns a different set of fields for each number below 64.
std::string fields_of(std::size_t number) {
  std::string text;
  for (const char* name : {"stamp.sec", "stamp.nanosec", "height", "width", "name", "data"}) {
    if (number % 2 == 1) text += (text.empty() ? "" : ", ") + std::string(name);
    number /= 2;
  }
  return text;
}

/// One reader for each mask, all behind a socket with a full send buffer. Each new sample makes a lane drop
/// its oldest one.
class ManyMaskAllocations : public testing::Test {
 protected:
  ManyMaskAllocations() {
    connections_.take_batches(0);
    side_->max_sample_bytes = std::size_t{1} << 20;
    for (std::size_t i = 0; i < masks; ++i) {
      FieldMask mask = fields<Image>(fields_of(i));
      const auto wire = std::make_shared<WireMask>(WireMask{static_cast<std::uint16_t>(i), mask.hash(), {}});
      Audience& audience = audiences_.emplace_back(
          Audience{detail::ProjectionPlan(type_.type(), std::move(mask)), nullptr, 0, false, wire, {}});
      audience.lanes.push_back(std::make_shared<Lane>(to_, lane_depth, tally_));
      audience.channels.emplace_back();
    }
    Image image = test::make_image(100'000);
    image.name = std::string(3000, 'n');
    const FieldMask all = fields<Image>("*");
    sample_ = memory_->take(test::sample_bytes(image, all));
    test::fill(*sample_, image, all, 7, 1);
  }

  /// Sends a sample under all masks. Returns the number of older samples that were dropped.
  std::size_t send() {
    std::size_t lost = 0;
    for (const Audience& audience : audiences_) lost += sender_.send(audience, sample_);
    return lost;
  }

  const TypeSupport& type_ = test::type_support<Image>();
  std::shared_ptr<core::BufferPool> memory_ = core::BufferPool::make(std::size_t{1} << 20);
  test::Connections connections_;
  std::shared_ptr<SendSide> side_ =
      std::make_shared<SendSide>(std::make_unique<test::NoSender>(connections_), DestinationLimits{});
  std::shared_ptr<WriterTally> tally_ = std::make_shared<WriterTally>();
  std::shared_ptr<Destination> to_ = side_->destinations.find({.ip = core::loopback_ipv4, .port = 1});
  std::vector<Audience> audiences_;
  VariantSender sender_{{.id = 7, .type = &type_}, side_, tally_, JobPool::make()};
  core::SampleHandle sample_;
};

/// A job that one mask no longer needs is used by the next mask. So each job is used by all masks in turn,
/// once in 64 samples.
TEST_F(ManyMaskAllocations, AreNoneOnceEachJobHasComeBackTwice) {
  for (std::size_t lost = 0; lost < 2 * lane_depth * masks;) lost += send();
  std::size_t lost = 0;
  const std::uint64_t allocations = allocations_of([&] {
    for (std::size_t i = 0; i < 2 * masks; ++i) lost += send();
  });
  EXPECT_EQ(allocations, 0U);
  EXPECT_EQ(lost, 2 * masks * masks) << "each sample costs each lane one";
}

/// The sending thread takes the list of lanes, and leaves an empty list for the next lanes.
class ScheduledWorkAllocations : public testing::Test {
 protected:
  ScheduledWorkAllocations() {
    for (std::size_t i = 0; i < masks; ++i) lanes_.push_back(sending_.lane());
  }
  void hand_over(std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) sending_.scheduled.add(lanes_[i]);
    sending_.scheduled.take(taken_);
    EXPECT_EQ(taken_.lanes.size(), count);
    taken_.lanes.clear();
  }

  test::Sending sending_;
  std::vector<std::shared_ptr<Lane>> lanes_;
  ScheduledWork::Taken taken_;
};

TEST_F(ScheduledWorkAllocations, AreNoneForAFewLanesFromTheBeginning) {
  EXPECT_EQ(allocations_of([&] {
              for (int i = 0; i < 4; ++i) hand_over(ScheduledWork::Taken::few);
            }),
            0U);
}

TEST_F(ScheduledWorkAllocations, AreNoneAfterBothListsHaveGrownToTheNumberOfLanes) {
  hand_over(masks);
  hand_over(1);
  hand_over(1);
  EXPECT_EQ(allocations_of([&] {
              for (int i = 0; i < 4; ++i) hand_over(masks);
            }),
            0U);
}

}  // namespace
}  // namespace sft::udp
