// Tests for how long accounts that other nodes have reported are kept, and how many accounts the table can
// hold.
#include "core/node/account_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/heap_bytes.h"
#include "tests/unit/core/start.h"

namespace sft::core {
namespace {

using namespace std::chrono_literals;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class AccountTableTest : public ::testing::Test {
 protected:
  void camera_sent(std::uint64_t samples) {
    table.enter({.id = {{1, 2}, Role::writer}, .by_writer = {.sent = samples}}, now);
  }
  void monitor_received(std::uint64_t samples) {
    table.enter({.id = {{1, 2}, Role::reader}, .by_reader = {.received = samples, .lost = 1}}, now);
  }

  AccountTable table;
  Time now = test_start;
};

TEST_F(AccountTableTest, APairHasTheAccountsOfBothSidesWithTheirAges) {
  camera_sent(5);
  EXPECT_FALSE(table.accounts(now).at({1, 2}).subscriber);
  now += 2s;
  monitor_received(4);
  const DomainSnapshot::Account pair = table.accounts(now).at({1, 2});
  EXPECT_EQ(pair.publisher->sent, 5U);
  EXPECT_EQ(pair.publisher->age, 2s);
  EXPECT_EQ(pair.subscriber->received, 4U);
  EXPECT_EQ(pair.subscriber->lost, 1U);
  EXPECT_EQ(pair.subscriber->age, 0s);
}

TEST_F(AccountTableTest, AnAccountIsKeptForTenSecondsUnlessItIsRenewed) {
  camera_sent(5);
  now += 6s;
  camera_sent(6);
  now += 10s - 1ms;
  EXPECT_EQ(table.accounts(now).at({1, 2}).publisher->sent, 6U);
  now += 1ms;
  EXPECT_THAT(table.accounts(now), IsEmpty());
}

TEST_F(AccountTableTest, AccountsAreKeptHoweverManyComeAfterThem) {
  camera_sent(5);
  for (EndpointId id = 1000; id < 10'000; ++id) table.enter({.id = {{id, 2}, Role::writer}}, now);
  camera_sent(6);
  const PairAccounts accounts = table.accounts(now);
  EXPECT_THAT(accounts, SizeIs(AccountTable::accounts_max));
  EXPECT_EQ(accounts.at({1, 2}).publisher->sent, 6U);
}

TEST_F(AccountTableTest, LeavesNothingOfAccountsThatAreOver) {
  const auto come_and_go = [&] {
    camera_sent(5);
    now += 10s;
    table.accounts(now);
  };
  EXPECT_LT(sft::test::bytes_left_by(come_and_go), sft::test::nothing_left);
}

TEST_F(AccountTableTest, IsEmptyOnceItIsCleared) {
  camera_sent(5);
  table.clear();
  EXPECT_THAT(table.accounts(now), IsEmpty());
  camera_sent(6);
  EXPECT_THAT(table.accounts(now), SizeIs(1));
}

}  // namespace
}  // namespace sft::core
