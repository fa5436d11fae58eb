// These tests check which multicast groups a process is in.
#include "udp_transport/io/group_joins.h"

#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "core/platform/ip_address.h"
#include "udp_transport/io/interfaces.h"

namespace sft::udp {
namespace {

class GroupJoinsTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!socket_->groups.group_fd) GTEST_SKIP() << "the port of groups is not to be had";
  }
  static std::uint32_t group(std::size_t number) {
    return private_groups | 16U << 8 | static_cast<std::uint32_t>(number);
  }
  void join(std::size_t number) { joins_.join(group(number), {core::loopback_ipv4, 7}, false); }
  /// Leaves the group. Returns true if the process was a member; if not, the system refuses the call.
  bool was_in(std::size_t number) const {
    const ip_mreq request{.imr_multiaddr = {htonl(group(number))}, .imr_interface = {htonl(INADDR_LOOPBACK)}};
    return ::setsockopt(socket_->groups.group_fd.get(), IPPROTO_IP, IP_DROP_MEMBERSHIP, &request,
                        sizeof request) == 0;
  }

  const std::shared_ptr<const UdpSocket> socket_ =
      open_udp_socket(
          {.bind = {core::loopback_ipv4, 0}, .receive_buffer_bytes = 100'000, .hears_groups = true})
          .value();
  GroupJoins joins_{socket_};
};

/// If a new group replaced an old one, two writers could make the process join and leave their groups
/// without end.
TEST_F(GroupJoinsTest, AProcessThatIsInTooManyGroupsStaysInThemAndJoinsNoOther) {
  for (std::size_t i = 0; i <= GroupJoins::joins_max; ++i) join(i);
  EXPECT_FALSE(was_in(GroupJoins::joins_max));
  for (std::size_t i = 0; i < GroupJoins::joins_max; ++i) EXPECT_TRUE(was_in(i)) << i;
}

TEST_F(GroupJoinsTest, AProcessThatLeavesAGroupHasRoomForAnotherOne) {
  std::vector<std::uint32_t> kept;
  for (std::size_t i = 0; i < GroupJoins::joins_max; ++i) {
    join(i);
    if (i != 3) kept.push_back(group(i));
  }
  joins_.keep_to(kept);
  join(100);
  EXPECT_FALSE(was_in(3));
  EXPECT_TRUE(was_in(100));
}

}  // namespace
}  // namespace sft::udp
