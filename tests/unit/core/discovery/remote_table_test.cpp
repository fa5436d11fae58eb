// A table lacks records ("is behind") if two successive heartbeats have digests that the table has had
// neither before nor after them.
#include "core/discovery/remote_table.h"

#include <gtest/gtest.h>

namespace sft::core {
namespace {

using namespace std::chrono_literals;

/// The owner has one record, which changes. Only some of the changes arrive.
class RemoteTableTest : public ::testing::Test {
 protected:
  static constexpr Time::duration apart = 250ms;

  /// Returns the digest of the owner's records after `changes` changes.
  std::uint64_t digest(std::uint64_t changes) const {
    Records own;
    if (changes > 0) own.put({}, {changes, nullptr});
    return own.digest();
  }
  void arrives(std::uint64_t change) { table.put({}, {change, nullptr}); }
  void heartbeat(std::uint64_t changes, Time::duration later = 1s) {
    now += later;
    table.expect(digest(changes), apart, now);
  }
  bool is_behind() const { return table.behind_since().has_value(); }

  Time now = Time(100s);
  RemoteTable table;
};

TEST_F(RemoteTableTest, IsNotBehindWhileAllArrives) {
  for (std::uint64_t change = 1; change < 10; ++change) {
    arrives(change);
    heartbeat(change);
    heartbeat(change);
    EXPECT_FALSE(is_behind()) << change;
  }
}

TEST_F(RemoteTableTest, IsBehindSinceTheSecondHeartbeatThatCountsMore) {
  heartbeat(1);
  EXPECT_FALSE(is_behind()) << "the record may be under way";
  heartbeat(1);
  EXPECT_EQ(table.behind_since(), now);
  const Time since = now;
  heartbeat(2);
  EXPECT_EQ(table.behind_since(), since);
  arrives(2);
  EXPECT_FALSE(is_behind());
}

TEST_F(RemoteTableTest, IsBehindWhereHeartbeatsGoOnWithoutWhatCame) {
  arrives(1);
  heartbeat(1);
  arrives(7);  // a forged change
  heartbeat(1);
  heartbeat(1);
  EXPECT_TRUE(is_behind());
}

TEST_F(RemoteTableTest, CountsHeartbeatsOfOneMomentAsOne) {
  heartbeat(1);
  heartbeat(2, 10ms);
  heartbeat(3, 10ms);
  EXPECT_FALSE(is_behind());
}

TEST_F(RemoteTableTest, IsNotBehindAHeartbeatThatIsOlderThanWhatCame) {
  arrives(1);
  heartbeat(1);
  for (std::uint64_t change = 2; change < 100; ++change) {
    arrives(change);
    arrives(change + 1);
    heartbeat(change);
    EXPECT_FALSE(is_behind()) << change;
  }
}

TEST_F(RemoteTableTest, IsNotBehindHeartbeatsThatOvertakeWhatFollows) {
  for (std::uint64_t change = 1; change < 100; ++change) {
    heartbeat(change + 1, 500ms);
    arrives(change);
    arrives(change + 1);
    EXPECT_FALSE(is_behind()) << change;
  }
}

TEST_F(RemoteTableTest, StaysBehindUntilItComesToTheSecondOfThem) {
  heartbeat(1);
  heartbeat(2);
  heartbeat(3);
  arrives(1);
  EXPECT_TRUE(is_behind()) << "two more heartbeats count what has not come";
  arrives(2);
  EXPECT_FALSE(is_behind());
}

TEST_F(RemoteTableTest, HoldsWhatMattersOfHeartbeatsWithoutEnd) {
  heartbeat(1);
  heartbeat(2);
  const Time since = now;
  for (std::uint64_t change = 3; change < 1000; ++change) heartbeat(change);
  EXPECT_EQ(table.behind_since(), since);
  arrives(999);
  EXPECT_FALSE(is_behind());
}

TEST_F(RemoteTableTest, RemembersADigestUntilAThousandChangesHaveFollowed) {
  for (std::uint64_t change = 1; change <= 2000; ++change) arrives(change);
  EXPECT_FALSE(table.expect(digest(900), apart, now));
  EXPECT_TRUE(table.expect(digest(1000), apart, now));
}

TEST_F(RemoteTableTest, IsNotBehindOnceWhatHeartbeatsSaidIsForgotten) {
  heartbeat(1);
  heartbeat(1);
  table.expect_nothing();
  EXPECT_FALSE(is_behind());
}

}  // namespace
}  // namespace sft::core
