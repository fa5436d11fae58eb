#include "udp_transport/io/answer_address.h"

#include <gtest/gtest.h>

namespace sft::udp {
namespace {

constexpr core::IpAddress its_ip{0x0A630102}, its_other_ip{0x0A640102}, third_ip{0x0A630109};

core::Announced node(bool same_network = false) {
  return {true, {{its_ip, 7000}, {its_other_ip, 7000}}, same_network};
}

TEST(AnswerAddressTest, IsWhereADatagramCameFromIfThatWasAnnounced) {
  EXPECT_EQ(answer_address(node(), its_other_ip, 4000), (SocketAddress{its_other_ip, 4000}));
}

TEST(AnswerAddressTest, IsNeverOfAThirdHost) {
  EXPECT_EQ(answer_address(node(), third_ip, 4000), (SocketAddress{its_ip, 4000}));
  EXPECT_FALSE(answer_address(node(), core::loopback_ipv6, 4000)) << "nothing of that family was announced";
}

TEST(AnswerAddressTest, IsOnLoopbackOnlyInOneNetworkStack) {
  EXPECT_EQ(answer_address(node(true), core::loopback_ipv4, 4000),
            (SocketAddress{core::loopback_ipv4, 4000}));
  EXPECT_EQ(answer_address(node(), core::loopback_ipv4, 4000), (SocketAddress{its_ip, 4000}));
  EXPECT_FALSE(answer_address({true, {{core::loopback_ipv4, 7000}}, false}, core::loopback_ipv4, 4000));
}

TEST(AnswerAddressTest, HasNoPrivilegedPortUnlessThatWasAnnounced) {
  EXPECT_FALSE(answer_address(node(), its_ip, 53));
  EXPECT_EQ(answer_address({true, {{its_ip, 700}}, false}, its_ip, 700), (SocketAddress{its_ip, 700}));
}

TEST(AnswerAddressTest, IsNoneWhereNothingWasAnnounced) {
  EXPECT_FALSE(answer_address({true, {}, false}, its_ip, 4000));
}

TEST(AnswerAddressTest, IsAnyWhereNothingIsKnownOfTheNode) {
  EXPECT_EQ(answer_address({}, third_ip, 4000), (SocketAddress{third_ip, 4000}));
}

}  // namespace
}  // namespace sft::udp
