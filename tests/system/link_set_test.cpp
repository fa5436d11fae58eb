// The links of a process are made anew where that helps.
#include "core/discovery/link_set.h"

#include <gtest/gtest.h>

#include <chrono>

#include "tests/system/control_ear.h"

namespace sft::core {
namespace {

using namespace std::chrono_literals;

TEST(LinkSetTest, ALinkIsNotMadeAnewAtOnceThatWasMadeAnewAMomentAgo) {
  const LinkSpec loopback{
      .interface = "lo", .ip = loopback_ipv4, .prefix_bits = 8, .loopback = true, .reaches_own_host = true};
  const OwnAnnouncements own;
  DiscoveryEar ear(life_signs_to_all);
  LinkSet links({.config = dds_config(test::control_domain(), {}, "").value(),
                 .threads = {},
                 .life_signs = life_signs_to_all},
                own, ear);
  const auto now = std::chrono::steady_clock::now();
  ASSERT_TRUE(links.use({loopback}, {}, now));
  EXPECT_TRUE(links.renew(1, "a participant is not heard", now));
  EXPECT_FALSE(links.renew(2, "a participant is not heard", now + 400ms));
  EXPECT_TRUE(links.renew(2, "a participant is not heard", now + 500ms));
  EXPECT_EQ(links.take_renewals().size(), 2U);
}

}  // namespace
}  // namespace sft::core
