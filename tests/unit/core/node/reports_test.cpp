// The reports of a node on its own endpoints, which it gives to nodes that inquire.
#include "core/node/reports.h"

#include "tests/support/heap_bytes.h"
#include "tests/unit/core/node/local_endpoint_fixture.h"

namespace sft::core {
namespace {

using namespace std::chrono_literals;
using ::testing::SizeIs;

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

/// How long accounts that other nodes have reported are kept, and how many of them.
class KeptAccountsTest : public OwnReportsTest {
 protected:
  KeptAccountsTest() {
    negotiation.endpoint_seen(over_network(Role::writer, 1));
    negotiation.endpoint_seen(over_network(Role::reader, 2));
    reports.ask("points");
  }
  void enter(const Account& account) { reports.received({.accounts = {account}}, now); }
  void camera_sent(std::uint64_t samples) {
    enter({.id = {{1, 2}, Role::writer}, .by_writer = {.sent = samples}});
  }

  Time now{1h};
};

TEST_F(KeptAccountsTest, APairHasTheAccountsOfBothSidesWithTheirAges) {
  camera_sent(5);
  EXPECT_FALSE(reports.accounts(now).at({1, 2}).subscriber);
  now += 2s;
  enter({.id = {{1, 2}, Role::reader}, .by_reader = {.received = 4, .lost = 1}});
  const DomainSnapshot::Account pair = reports.accounts(now).at({1, 2});
  EXPECT_EQ(pair.publisher->sent, 5U);
  EXPECT_EQ(pair.publisher->age, 2s);
  EXPECT_EQ(pair.subscriber->received, 4U);
  EXPECT_EQ(pair.subscriber->lost, 1U);
  EXPECT_EQ(pair.subscriber->age, 0s);
}

TEST_F(KeptAccountsTest, AnAccountIsKeptForTenSecondsUnlessItIsRenewed) {
  camera_sent(5);
  now += 6s;
  camera_sent(6);
  now += 10s - 1ms;
  EXPECT_EQ(reports.accounts(now).at({1, 2}).publisher->sent, 6U);
  now += 1ms;
  EXPECT_THAT(reports.accounts(now), IsEmpty());
}

TEST_F(KeptAccountsTest, AccountsAreKeptHoweverManyComeAfterThem) {
  camera_sent(5);
  for (EndpointId id = 1000; id < 1000 + 2 * Reports::accounts_kept_max; ++id) {
    negotiation.endpoint_seen(over_network(Role::writer, id));
    enter({.id = {{id, 2}, Role::writer}});
  }
  camera_sent(6);
  const PairAccounts accounts = reports.accounts(now);
  EXPECT_THAT(accounts, SizeIs(Reports::accounts_kept_max));
  EXPECT_EQ(accounts.at({1, 2}).publisher->sent, 6U);
}

TEST_F(KeptAccountsTest, LeavesNothingOfAccountsThatAreOver) {
  const auto come_and_go = [&] {
    camera_sent(5);
    now += 10s;
    reports.accounts(now);
  };
  EXPECT_LT(sft::test::bytes_left_by(come_and_go), sft::test::nothing_left);
}

}  // namespace
}  // namespace sft::core
