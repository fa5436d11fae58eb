#include "udp_transport/flow/remote_path.h"

#include <gtest/gtest.h>

namespace sft::udp {
namespace {

using namespace std::chrono_literals;

class RemotePathTest : public testing::Test {
 protected:
  /// Reports the loss of long datagrams until the path counts as unable to carry their length.
  void lose_long_ones() {
    for (int i = 0; i < PathMtu::losses_max; ++i, now_ += PathMtu::timeout) path_.were_lost(ethernet, now_);
  }

  static constexpr std::size_t ethernet = 1472;
  const SocketAddress there_{0x0A000001U, 5000}, elsewhere_{0x0A090003U, 5000};
  RemotePath::Time now_{1h};
  RemotePath path_{there_, ethernet};
};

TEST_F(RemotePathTest, TakesDatagramsAsLongAsTheKernelSays) {
  EXPECT_EQ(path_.datagram_bytes(), ethernet);
  EXPECT_FALSE(path_.length_is_uncertain());
  path_.learn_length(there_, 1372);
  EXPECT_EQ(path_.datagram_bytes(), 1372U);
}

TEST_F(RemotePathTest, IgnoresWhatTheKernelSaidOfAFormerAddress) {
  EXPECT_TRUE(path_.move_to(elsewhere_));
  path_.learn_length(there_, 1372);
  EXPECT_EQ(path_.datagram_bytes(), ethernet);
}

TEST_F(RemotePathTest, TakesShorterDatagramsWhereLongOnesGetLostAndThenTriesLongerOnes) {
  path_.were_lost(ethernet, now_);
  EXPECT_TRUE(path_.length_is_uncertain());
  lose_long_ones();
  const std::size_t shortened = path_.datagram_bytes();
  EXPECT_LT(shortened, ethernet);
  path_.arrived(path_.datagram_bytes(), now_);
  path_.look_after(now_ + PathMtu::search_pause);
  EXPECT_GT(path_.datagram_bytes(), shortened);
}

TEST_F(RemotePathTest, ForgetsOnAnotherPathWhichDatagramsWereLost) {
  lose_long_ones();
  EXPECT_TRUE(path_.move_to(elsewhere_));
  EXPECT_LT(path_.datagram_bytes(), ethernet) << "nothing is known of the other path yet";
  path_.measure_anew(elsewhere_, 8972);
  EXPECT_EQ(path_.datagram_bytes(), 8972U);
  EXPECT_FALSE(path_.length_is_uncertain());
}

TEST_F(RemotePathTest, IsWhereItIsSentToAndWhereAnswersCameFrom) {
  EXPECT_TRUE(path_.is_at(there_.ip));
  EXPECT_FALSE(path_.is_at(elsewhere_.ip));
  path_.learn(elsewhere_.ip);
  EXPECT_TRUE(path_.is_at(there_.ip));
  EXPECT_TRUE(path_.is_at(elsewhere_.ip));
  EXPECT_EQ(path_.address(), there_);
}

TEST_F(RemotePathTest, RemembersTheLastFewAddressesThatAnswersCameFrom) {
  const auto number = [](std::size_t n) { return core::IpAddress(static_cast<std::uint32_t>(100 + n)); };
  for (std::size_t n = 0; n <= RemotePath::also_at_max; ++n) path_.learn(number(n));
  EXPECT_FALSE(path_.is_at(number(0)));
  for (std::size_t n = 1; n <= RemotePath::also_at_max; ++n) EXPECT_TRUE(path_.is_at(number(n))) << n;
  EXPECT_TRUE(path_.is_at(there_.ip));
}

TEST_F(RemotePathTest, HasItsNewAddressOnlyAfterAMove) {
  path_.learn(core::IpAddress(77U));
  EXPECT_FALSE(path_.move_to(there_)) << "it is there already";
  EXPECT_TRUE(path_.is_at(core::IpAddress(77U)));
  EXPECT_TRUE(path_.move_to(elsewhere_));
  EXPECT_EQ(path_.address(), elsewhere_);
  EXPECT_FALSE(path_.is_at(there_.ip));
  EXPECT_FALSE(path_.is_at(core::IpAddress(77U)));
}

}  // namespace
}  // namespace sft::udp
