// A process gives its records slots, which it reuses, and sends a heartbeat when records have changed.
#include "core/discovery/own_records.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace sft::core {
namespace {

using namespace std::chrono_literals;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class OwnRecordsTest : public ::testing::Test {
 protected:
  std::optional<OwnRecords::Change> announce(std::uint64_t owner, const std::string& text) {
    return put(owner, RecordKind::announcement, text);
  }
  std::optional<OwnRecords::Change> put(std::uint64_t owner, RecordKind kind, const std::string& text) {
    const auto* const first = reinterpret_cast<const std::byte*>(text.data());
    return own.put(Role::reader, owner, kind, {first, first + text.size()}, now);
  }
  std::vector<OwnRecords::Change> withdraw(std::uint64_t owner) {
    return own.withdraw(Role::reader, owner, now);
  }
  Time::duration until_heartbeat() const { return own.heartbeat_due() - now; }

  const Timing timing;
  Time now = Time(100s);
  OwnRecords own{5, timing};
};

TEST_F(OwnRecordsTest, HaveAGreaterRevisionWithEachChange) {
  const auto first = announce(1, "a"), second = announce(2, "b"), changed = announce(1, "c");
  EXPECT_LT(first->record.revision, second->record.revision);
  EXPECT_LT(second->record.revision, changed->record.revision);
  EXPECT_EQ(changed->key, first->key);
  EXPECT_NE(second->key, first->key);
}

TEST_F(OwnRecordsTest, ThatSayWhatTheySaidBeforeAreNotWrittenAgain) {
  announce(1, "a");
  const auto digests = own.digests();
  EXPECT_FALSE(announce(1, "a"));
  EXPECT_EQ(own.digests(), digests);
}

TEST_F(OwnRecordsTest, OfOneEndpointShareASlotWhichTheNextOneGets) {
  const auto announced = announce(1, "a"), asked = put(1, RecordKind::request, "b");
  EXPECT_EQ(announced->key.slot, asked->key.slot);
  const std::vector<OwnRecords::Change> gone = withdraw(1);
  ASSERT_THAT(gone, SizeIs(2));
  for (const OwnRecords::Change& change : gone) EXPECT_TRUE(change.record.is_withdrawn());
  const auto next = announce(2, "c");
  EXPECT_EQ(next->key, announced->key);
  EXPECT_GT(next->record.revision, gone[1].record.revision);
  EXPECT_NE(announce(3, "d")->key.slot, next->key.slot);
}

TEST_F(OwnRecordsTest, OfNobodyAreNotWithdrawn) {
  EXPECT_THAT(withdraw(1), IsEmpty());
  announce(1, "a");
  withdraw(1);
  EXPECT_THAT(withdraw(1), IsEmpty());
}

TEST_F(OwnRecordsTest, OfManyEndpointsOneAfterTheOtherTakeOneSlot) {
  for (std::uint64_t owner = 1; owner <= 1000; ++owner) {
    announce(owner, "a");
    withdraw(owner);
  }
  EXPECT_THAT(own.records(Role::reader).all(), SizeIs(1));
}

TEST_F(OwnRecordsTest, AreCountedByAHeartbeatAtOnceAndOnceMoreSoon) {
  own.heartbeat_given(now);
  EXPECT_EQ(until_heartbeat(), timing.heartbeat_every);
  now += 700ms;
  announce(1, "a");
  EXPECT_EQ(until_heartbeat(), 0ms);
  own.heartbeat_given(now);
  EXPECT_EQ(until_heartbeat(), timing.heartbeat_pause);
  now += timing.heartbeat_pause;
  own.heartbeat_given(now);
  EXPECT_EQ(until_heartbeat(), timing.heartbeat_every);
}

TEST_F(OwnRecordsTest, ThatDoNotChangeAreCountedALittleEarlyByWhoLooksThen) {
  own.heartbeat_given(now);
  now += 900ms;
  EXPECT_FALSE(own.is_heartbeat_due(now));
  now += 32ms;
  EXPECT_TRUE(own.is_heartbeat_due(now));
  own.heartbeat_given(now);
  now += timing.heartbeat_pause - 1ms;
  announce(1, "a");
  EXPECT_FALSE(own.is_heartbeat_due(now)) << "a change waits for the whole pause";
  EXPECT_TRUE(own.is_heartbeat_due(now + 1ms));
}

TEST_F(OwnRecordsTest, ThatChangeWithoutEndCostTwoHeartbeatsASecond) {
  int heartbeats = 0;
  for (int i = 0; i < 10'000; ++i) {
    now += 1ms;
    announce(1, std::to_string(i));
    if (own.heartbeat_due() > now) continue;
    own.heartbeat_given(now);
    ++heartbeats;
  }
  EXPECT_EQ(heartbeats, 20);
}

}  // namespace
}  // namespace sft::core
