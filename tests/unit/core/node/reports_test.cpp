// The reports of a node on its own endpoints, which it gives to nodes that inquire.
#include "core/node/reports.h"

#include "tests/unit/core/node/local_endpoint_fixture.h"

namespace sft::core {
namespace {

using namespace std::chrono_literals;

class OwnReportsTest : public LocalEndpointTest {
 protected:
  LocalEndpoints ours;
  VanillaAccess vanilla{{}, log};
  Reports reports{negotiation, ours, discovery, vanilla};
};

TEST_F(OwnReportsTest, AreDueAgainOnlyAfterAPause) {
  const Time now{1h};
  ASSERT_TRUE(reports.is_due(now));
  reports.take(now);
  EXPECT_FALSE(reports.is_due(now));
  EXPECT_FALSE(reports.is_due(now + 800ms));
  EXPECT_TRUE(reports.is_due(now + 1s));
}

}  // namespace
}  // namespace sft::core
