// The list of endpoints of unmodified nodes that a participant of Cyclone DDS has discovered.
#include "core/vanilla/vanilla_endpoints.h"

#include <gtest/gtest.h>

#include "core/vanilla/raw_sample.h"
#include "tests/support/eventually.h"

namespace sft::core {
namespace {

using namespace std::chrono_literals;

/// A participant that discovers no other one. Its own writers stand for those of others.
class VanillaEndpointsTest : public testing::Test {
 protected:
  VanillaEndpointsTest()
      : domain_(dds_create_domain(number,
                                  "<General><Interfaces><NetworkInterface name=\"lo\"/></Interfaces>"
                                  "<AllowMulticast>false</AllowMulticast></General>")),
        participant_(dds_create_participant(number, nullptr, nullptr)),
        topic_(raw_topic(participant_, "rt/points", "points")) {}
  ~VanillaEndpointsTest() override {
    known_.reset();
    dds_delete(domain_);
  }

  void know_at_most(std::size_t endpoints) {
    known_ = std::make_unique<VanillaEndpoints>(participant_, DDS_BUILTIN_TOPIC_DCPSPUBLICATION,
                                                std::function<void()>(), endpoints);
  }
  dds_entity_t writer() const { return dds_create_writer(participant_, topic_.entity, nullptr, nullptr); }
  bool comes_to(std::size_t endpoints) const {
    return sft::test::eventually([&] { return known_->of("rt/points").size() == endpoints; });
  }
  std::size_t after_a_look(Time::duration pause) {
    known_->look_again(now_ += pause);
    return known_->of("rt/points").size();
  }

  static constexpr dds_domainid_t number = 199;
  const dds_entity_t domain_, participant_;
  const RawTopic topic_;
  std::unique_ptr<VanillaEndpoints> known_;

 private:
  Time now_{1h};
};

TEST_F(VanillaEndpointsTest, AreKnownWhetherTheyCameBeforeOrComeLaterAndForgottenWhenTheyGo) {
  const dds_entity_t earlier = writer();
  ASSERT_GT(earlier, 0);
  know_at_most(10);
  EXPECT_TRUE(comes_to(1));
  const dds_entity_t later = writer();
  EXPECT_TRUE(comes_to(2));
  dds_delete(earlier);
  dds_delete(later);
  EXPECT_TRUE(comes_to(0));
}

TEST_F(VanillaEndpointsTest, OfTheControlTopicsOfSftAreNone) {
  know_at_most(10);
  const RawTopic control = raw_topic(participant_, "sft_writer", "sft_control::Record");
  ASSERT_GT(dds_create_writer(participant_, control.entity, nullptr, nullptr), 0);
  ASSERT_GT(writer(), 0);
  EXPECT_TRUE(comes_to(1));
  EXPECT_EQ(known_->all().size(), 1U);
}

TEST_F(VanillaEndpointsTest, ForWhichThereWasNoRoomAreFoundAgainWhenOthersHaveGone) {
  know_at_most(2);
  const dds_entity_t first = writer(), second = writer(), third = writer();
  EXPECT_TRUE(comes_to(2));
  EXPECT_EQ(after_a_look(1min), 2U);
  dds_delete(first);
  EXPECT_TRUE(comes_to(1));
  EXPECT_EQ(after_a_look(0s), 2U);
  dds_delete(second);
  EXPECT_TRUE(comes_to(1));
  dds_delete(third);
  EXPECT_TRUE(comes_to(0)) << "the one that was found again is forgotten like any other one";
}

TEST_F(VanillaEndpointsTest, AreLookedForNowAndThenOnlyAndNotIfNoneWasIgnored) {
  know_at_most(1);
  dds_entity_t known = writer(), ignored = writer(), last = writer();
  dds_delete(known);
  EXPECT_TRUE(comes_to(0));
  EXPECT_EQ(after_a_look(0s), 1U);
  dds_delete(ignored);
  dds_delete(last);
  EXPECT_TRUE(comes_to(0));
  known = writer(), ignored = writer();
  dds_delete(known);
  EXPECT_TRUE(comes_to(0));
  EXPECT_EQ(after_a_look(VanillaEndpoints::looks_apart - 1ms), 0U);
  EXPECT_EQ(after_a_look(1ms), 1U);
}

}  // namespace
}  // namespace sft::core
