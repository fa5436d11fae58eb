// Tests of reading the counters of an interface.
#include <gtest/gtest.h>

#include "tools/hosts/interface_counters.h"

namespace sft::demo {
namespace {

constexpr const char* proc_net_dev =
    "Inter-|   Receive                                                |  Transmit\n"
    " face |bytes    packets errs drop fifo frame compressed multicast|bytes    packets errs drop fifo colls "
    "carrier\n"
    "    lo:     100       2    0    0    0     0          0         0      100       2    0    0    0     0 "
    "      0\n"
    "  eth0: 18446744073709551615 7 0 0 0 0 0 3 4096 9 0 0 0 0 0\n"
    "veth_eth0: 1 1 0 0 0 0 0 0 2 2 0 0 0 0 0\n";

TEST(Counters, AreThoseOfTheInterface) {
  const auto eth0 = hosts::parse_interface_bytes(proc_net_dev, "eth0");
  ASSERT_TRUE(eth0);
  EXPECT_EQ(eth0->received, 18446744073709551615ULL);
  EXPECT_EQ(eth0->sent, 4096U);
  const auto lo = hosts::parse_interface_bytes(proc_net_dev, "lo");
  ASSERT_TRUE(lo);
  EXPECT_EQ(lo->received, 100U);
}

TEST(Counters, OfAnInterfaceThatIsNotThereAreNone) {
  EXPECT_FALSE(hosts::parse_interface_bytes(proc_net_dev, "eth"));
  EXPECT_FALSE(hosts::parse_interface_bytes(proc_net_dev, "eth1"));
  EXPECT_FALSE(hosts::parse_interface_bytes("", "eth0"));
}

}  // namespace
}  // namespace sft::demo
