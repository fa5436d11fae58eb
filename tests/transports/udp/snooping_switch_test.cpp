// A publisher, two readers and a host without readers, on a switch with IGMP snooping. If there is a querier,
// the switch forwards the datagrams of a group only to ports that have reported membership. Without a querier
// it forwards none.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <chrono>
#include <vector>

#include "core/platform/file_descriptor.h"
#include "tests/transports/udp/bridge_fixture.h"

namespace sft::udp {
namespace {

constexpr std::size_t samples_watched = 100;
constexpr std::size_t sample_bytes = 8000;  // a lower bound of the bytes of a sample
constexpr const char* bystander = "port4";

/// The bridge uses IGMPv3. With an older version the bridge would forward each host's report to all other
/// hosts during its first seconds. The other hosts would then suppress their own reports, and the bridge
/// would not learn of their memberships. The bridge filters groups without members once a querier has waited
/// for its response interval, here 0.1 s.
class SnoopingSwitchTest : public test::BridgeTest {
 protected:
  void SetUp() override {
    if (!sft::test::isolation_refusal().empty()) GTEST_SKIP() << sft::test::isolation_refusal();
    if (!make_bridge("mcast_snooping 1 mcast_igmp_version 3 mcast_query_response_interval 10") ||
        !test::run("ip link set bridge arp off up"))
      GTEST_SKIP() << "no bridge that snoops on IGMP can be made here";
    ASSERT_TRUE(plug_in(1, "end1") && switch_on(1, "end1"));
    open_publisher();
  }

  static void switch_querier_on() {
    ASSERT_TRUE(test::run("ip link set bridge type bridge mcast_querier 1"));
  }
  /// Waits until the switch filters. Before that, a host receives a group at once although the switch does
  /// not know of its membership, because the host's kernel reports some milliseconds later. If the switch
  /// began to filter in between, best-effort samples would be lost, and no publisher could know.
  bool holds_back_what_nobody_joined() {
    const core::FileDescriptor socket(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
    const int yes = 1;
    const in_addr own{::inet_addr("10.20.0.1")};
    EXPECT_EQ(::setsockopt(socket.get(), SOL_SOCKET, SO_BROADCAST, &yes, sizeof yes), 0);
    EXPECT_EQ(::setsockopt(socket.get(), IPPROTO_IP, IP_MULTICAST_IF, &own, sizeof own), 0);
    return test::eventually([&] {
      const std::uint32_t before = test::traffic_of(bystander).sent;
      const auto came = [before] { return test::traffic_of(bystander).sent - before; };
      send(socket, "239.255.1.1", sample_bytes);
      // A broadcast, which reaches all ports, and arrives last.
      send(socket, "10.20.0.255", 2 * sample_bytes);
      // A port that has just come up may have dropped both datagrams. Then both are sent again.
      return test::eventually([&] { return came() >= 2 * sample_bytes; }, std::chrono::seconds(1)) &&
             came() < 3 * sample_bytes;
    });
  }
  static void send(const core::FileDescriptor& socket, const char* address, std::size_t bytes) {
    const std::vector<char> datagram(bytes);
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(9);
    to.sin_addr.s_addr = ::inet_addr(address);
    EXPECT_EQ(
        ::sendto(socket.get(), datagram.data(), bytes, 0, reinterpret_cast<const sockaddr*>(&to), sizeof to),
        static_cast<ssize_t>(bytes));
  }
  void add_hosts(bool reliable) {
    ASSERT_TRUE(add_reader(2, "*", reliable));
    ASSERT_TRUE(add_reader(3, "*", reliable));
    ASSERT_TRUE(on_host(4, [&] { bystander_ = open_udp_transport({}, test::make_pool()).value(); }));
  }
  /// Publishes until groups serve all readers and the switch filters.
  bool group_passes_to_members_only() {
    return publish_until([this] {
      if (!all_are_in_groups()) return false;
      const std::uint32_t before = test::traffic_of(bystander).sent;
      publish(samples_watched);
      return test::traffic_of(bystander).sent - before < sample_bytes;
    });
  }

  std::unique_ptr<core::Network> bystander_;  ///< held so that its host stays
};

TEST_F(SnoopingSwitchTest, PassesAGroupOnToItsMembersOnly) {
  switch_querier_on();
  add_hosts(false);
  ASSERT_TRUE(holds_back_what_nobody_joined());
  serve(2);
  ASSERT_TRUE(group_passes_to_members_only() && !HasFatalFailure()) << publisher_->port().multicast(1);
  const std::uint32_t sent = test::traffic_of("port1").received;
  const std::uint32_t to_one = test::traffic_of("port2").sent, to_other = test::traffic_of("port3").sent;
  const std::uint32_t to_bystander = test::traffic_of(bystander).sent;
  publish(samples_watched);
  EXPECT_TRUE(all_came());
  EXPECT_LT(test::traffic_of("port1").received - sent, samples_watched * sample_bytes * 3 / 2) << "one copy";
  EXPECT_GE(test::traffic_of("port2").sent - to_one, samples_watched * sample_bytes);
  EXPECT_GE(test::traffic_of("port3").sent - to_other, samples_watched * sample_bytes);
  EXPECT_LT(test::traffic_of(bystander).sent - to_bystander, sample_bytes);
}

/// Such a switch never floods, or it has removed the members because no querier queries them.
TEST_F(SnoopingSwitchTest, CostsNoSampleWhilePassingNothingOnForWantOfAQuerier) {
  add_hosts(false);
  for (const char* port : {"port1", "port2", "port3", "port4"})
    ASSERT_TRUE(test::run("bridge link set dev " + std::string(port) + " mcast_flood off"));
  serve(2);
  ASSERT_TRUE(publish_until([this] { return publisher_->port().multicast(1).starts_with("group "); }));
  const std::uint32_t sent = test::traffic_of("port1").received, to_one = test::traffic_of("port2").sent;
  for (std::size_t i = 0; i < samples_watched; ++i) {
    publish();
    ASSERT_FALSE(HasFatalFailure() || hears(1) || hears(2));
  }
  EXPECT_TRUE(all_came());
  EXPECT_GE(test::traffic_of("port1").received - sent, 3 * samples_watched * sample_bytes)
      << "two, and the group's";
  EXPECT_LT(test::traffic_of("port2").sent - to_one, samples_watched * sample_bytes * 3 / 2);
  switch_querier_on();
  EXPECT_TRUE(group_passes_to_members_only()) << publisher_->port().multicast(1);
}

/// For instance, the switch was restarted, or the cable was moved to another port. Hosts report a membership
/// unasked only when the membership begins, and once more within a second. The next query comes much later.
TEST_F(SnoopingSwitchTest, IsToldAgainOfAMemberThatItHasForgotten) {
  switch_querier_on();
  add_hosts(true);
  serve(2);
  ASSERT_TRUE(group_passes_to_members_only() && !HasFatalFailure()) << publisher_->port().multicast(1);
  const std::string state = publisher_->port().multicast(1);
  const std::size_t begin = state.find(' ') + 1;
  const std::string group = state.substr(begin, state.find(' ', begin) - begin);
  const std::string forget = "bridge mdb delete dev bridge port port2 grp " + group + " 2> /dev/null";
  ASSERT_TRUE(test::run(forget)) << state;
  ASSERT_TRUE(publish_until([&] {
    test::run(forget);
    return !hears(1);
  }));
  EXPECT_TRUE(hears(2));
  EXPECT_TRUE(group_passes_to_members_only()) << publisher_->port().multicast(1);
  EXPECT_TRUE(all_came());
}

}  // namespace
}  // namespace sft::udp
