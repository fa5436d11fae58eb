// A sample for a multicast group whose members begin to receive the group while the sample is being sent.
#include "udp_transport/send/group_delivery.h"

#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "tests/unit/udp/connections.h"
#include "tests/unit/udp/jobs.h"
#include "udp_transport/send/variant_sender.h"

namespace sft::udp {
namespace {

using test::Image;

constexpr std::uint32_t writer = 7, group_number = 2;

/// Calls a function when the sending thread is woken for the first lane that gets a sample.
class ActingSender final : public test::NoSender {
 public:
  ActingSender(test::Connections& connections, const std::function<void()>& act)
      : NoSender(connections), act_(act) {}
  void wake() noexcept override { act_(); }

 private:
  const std::function<void()>& act_;
};

/// A group of two best-effort members. Its queue has room for a single sample.
class GroupDeliveryTest : public testing::Test {
 protected:
  GroupDeliveryTest() {
    side_->max_sample_bytes = std::size_t{1} << 20;
    side_->pool = memory_;
    std::vector<MulticastGroup::Member> members;
    for (std::uint16_t port = 1; port <= 2; ++port) {
      audience_.lanes.push_back(lane_to(core::loopback_ipv4, port));
      audience_.channels.push_back(nullptr);
      members.push_back({audience_.lanes.back(), nullptr});
    }
    group_ =
        MulticastGroup::make({writer, group_number, private_groups + 1},
                             lane_to(core::IpAddress(private_groups + 1), group_port), std::move(members), 9);
    audience_.multicast = group_;
  }

  /// The sending thread is woken once more when it is stopped.
  void TearDown() override {
    meanwhile_ = [] {};
  }

  std::shared_ptr<Lane> lane_to(const core::IpAddress& ip, std::uint16_t port) {
    return std::make_shared<Lane>(side_->destinations.find({.ip = ip, .port = port}), 1, tally_);
  }
  /// Both members report a probe that was sent to the group before the sample.
  void both_report(std::uint64_t probed) {
    for (std::size_t member = 0; member < 2; ++member)
      group_->hear({writer, group_number, group_->farewell(member).member, probed},
                   std::chrono::steady_clock::now());
  }
  std::size_t publish() {
    const Image image = test::make_image(10);
    const core::SampleHandle sample = memory_->take(test::sample_bytes(image, all_));
    test::fill(*sample, image, all_, writer, 1);
    return sender_.send(audience_, sample);
  }
  bool has_a_sample(std::size_t member) const { return audience_.lanes[member]->next() != nullptr; }

  const TypeSupport& type_ = test::type_support<Image>();
  const FieldMask all_ = test::fields<Image>("*");
  std::shared_ptr<core::BufferPool> memory_ = core::BufferPool::make(std::size_t{16} << 20);
  test::Connections connections_;
  std::function<void()> meanwhile_ = [] {};
  std::shared_ptr<SendSide> side_ = std::make_shared<SendSide>(
      std::make_unique<ActingSender>(connections_, meanwhile_), DestinationLimits{});
  std::shared_ptr<WriterTally> tally_ = std::make_shared<WriterTally>();
  Audience audience_{detail::ProjectionPlan(type_.type(), FieldMask(all_)),    nullptr, 0, false,
                     std::make_shared<WireMask>(WireMask{5, all_.hash(), {}}), {}};
  std::shared_ptr<MulticastGroup> group_;
  VariantSender sender_{{.id = writer, .type = &type_}, side_, tally_, JobPool::make()};
};

TEST_F(GroupDeliveryTest, ASampleForWhichTheGroupHasNoRoomGoesToEachMemberAlsoIfOneReportsMeanwhile) {
  const std::uint64_t probed = group_->next_ordinal(std::chrono::steady_clock::now());
  const auto jobs = JobPool::make();
  group_->lane()->post(test::make_job(*jobs, 1));
  meanwhile_ = [&] { both_report(probed); };
  EXPECT_EQ(publish(), 0U);
  EXPECT_TRUE(group_->hears(0) && group_->hears(1));
  EXPECT_TRUE(has_a_sample(0));
  EXPECT_TRUE(has_a_sample(1)) << "neither the group nor its own lane has the sample";
}

}  // namespace
}  // namespace sft::udp
