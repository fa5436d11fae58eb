// These tests check that the datagrams of a group are short enough for the paths to all members.
#include "tests/unit/udp/routing/group_keeper_fixture.h"

namespace sft::udp::test {
namespace {

TEST_F(GroupKeeperTest, MakesAGroupOfShorterDatagramsOnceLongOnesDoNotArriveAtAMember) {
  readers(2);
  serve();
  go_on(110ms);
  ASSERT_EQ(members(), 2U);
  const std::size_t before = connected_.back().datagram_bytes;
  EXPECT_EQ(go_on(10ms), 0);
  Destination& member = groups_.front()->members()[1].lane->destination();
  lose_long_ones(member, connections_, now_);
  EXPECT_EQ(go_on(10ms), 1);
  EXPECT_EQ(members(), 2U);
  EXPECT_LT(connected_.back().datagram_bytes, before);
  EXPECT_EQ(connected_.back().datagram_bytes, member.path().datagram_bytes());
}

}  // namespace
}  // namespace sft::udp::test
