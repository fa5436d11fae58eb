// Which writers the readers of a transport may hear at the same time.
#include "udp_transport/subscriptions.h"

#include <gtest/gtest.h>

#include "datagrams.h"

namespace sft::udp {
namespace {

class SubscriptionsTest : public testing::Test {
 protected:
  SubscriptionsTest() { directory_.add(1, inbox_, test::type_support<test::Image>()); }

  bool connects(core::EndpointId writer) {
    return directory_.connect(*inbox_, {.writer = writer}).has_value();
  }
  static core::EndpointId twin(std::uint64_t number) { return (number << 32) + 5; }

  std::shared_ptr<Inbox> inbox_ = std::make_shared<Inbox>(1, nullptr);
  SubscriptionDirectory directory_;
};

TEST_F(SubscriptionsTest, WritersWithOneShortIdAreHeardBesideEachOther) {
  EXPECT_TRUE(connects(twin(0)));
  EXPECT_TRUE(connects(twin(1)));
  EXPECT_EQ(directory_.enter()->streams.size(), 2U);
  directory_.leave();
}

TEST_F(SubscriptionsTest, AtMostSixteenWritersWithOneShortIdAreHeard) {
  for (std::uint64_t number = 0; number < 16; ++number) EXPECT_TRUE(connects(twin(number))) << number;
  EXPECT_FALSE(connects(twin(16)));
  EXPECT_TRUE(connects(twin(3))) << "it is one of them";
  EXPECT_TRUE(connects(6)) << "another short id";
}

}  // namespace
}  // namespace sft::udp
