// These tests check which thread has the receiving role. The tests call `role` for a waiting thread and for
// the transport's own thread in turn, in simulated time.
#include "udp_transport/receive/receiving_role.h"

#include <gtest/gtest.h>

#include "udp_transport/receive/spin_limits.h"

namespace sft::udp {
namespace {

using namespace std::chrono_literals;
using Duty = ReceivingRole::Duty;
using Entry = ReceivingRole::Entry;
using Time = ReceivingRole::Time;

class ReceivingRoleTest : public testing::Test {
 protected:
  Duty duty(bool readable = false) { return role.next(now, readable).duty; }
  /// Makes the transport's own thread sleep in the kernel, wake up, and pass the receiving role to the
  /// waiting thread.
  void pass_to_waiter() {
    ASSERT_EQ(duty(), Duty::receive);
    ASSERT_EQ(role.enter(now), Entry::promised);
    ASSERT_TRUE(role.end_turn(no_deadline));
  }
  void take_turn() {
    ASSERT_TRUE(role.begin());
    role.end(no_deadline);
  }

  static constexpr Time no_deadline = Time::max();
  Time now{1h};
  ReceivingRole role;
};

TEST_F(ReceivingRoleTest, StaysWithTheOwnThreadWhileNobodyWaits) {
  EXPECT_EQ(duty(), Duty::receive);
  EXPECT_FALSE(role.end_turn(no_deadline)) << "nobody is to be woken";
  EXPECT_EQ(duty(), Duty::receive);
}

TEST_F(ReceivingRoleTest, PassesToAWaitingThreadOnlyBetweenTurns) {
  EXPECT_EQ(duty(), Duty::receive);
  EXPECT_EQ(role.enter(now), Entry::promised);
  EXPECT_FALSE(role.begin()) << "two would receive";
  EXPECT_FALSE(role.lost());
  EXPECT_TRUE(role.end_turn(no_deadline)) << "it has to be told";
  EXPECT_EQ(duty(), Duty::stand_by);
  EXPECT_TRUE(role.begin());
}

TEST_F(ReceivingRoleTest, ReturnsToTheSameThreadWithoutWakingAnother) {
  pass_to_waiter();
  for (int i = 0; i < 10; ++i, now += 100us) {
    take_turn();
    const ReceivingRole::Leaving leaving = role.leave(now);
    EXPECT_EQ(leaving.set_alarm, i == 0) << "one alarm, until it rings";
    EXPECT_FALSE(leaving.wake);
    EXPECT_EQ(duty(), Duty::stand_by);
    EXPECT_EQ(role.enter(now), Entry::taken);
  }
  role.alarm_rang();
  EXPECT_TRUE(role.leave(now).set_alarm);
}

TEST_F(ReceivingRoleTest, FallsToTheOwnThreadIfNoThreadComesBackInTime) {
  pass_to_waiter();
  role.leave(now);
  const ReceivingRole::Task task = role.next(now, false);
  EXPECT_EQ(task.duty, Duty::stand_by);
  EXPECT_EQ(task.until, now + ReceivingRole::vacancy);
  now = task.until;
  EXPECT_EQ(duty(), Duty::poll) << "so that the next one need not wake it";
  EXPECT_EQ(role.enter(now), Entry::taken);
  EXPECT_FALSE(role.take_turn()) << "what it woke up for is that thread's now";
}

TEST_F(ReceivingRoleTest, BelongsToTheOwnThreadAgainWhenNoThreadHasWaitedForAWhile) {
  pass_to_waiter();
  role.leave(now);
  now += ReceivingRole::own_again;
  EXPECT_EQ(duty(), Duty::receive);
}

TEST_F(ReceivingRoleTest, BelongsToOneWaitingThreadAtATime) {
  pass_to_waiter();
  EXPECT_EQ(role.enter(now), Entry::occupied);
  EXPECT_FALSE(role.wait_behind()) << "the first one receives for it";
  take_turn();
  EXPECT_TRUE(role.leave(now).wake) << "a vacancy would leave it without its samples";
  EXPECT_EQ(duty(), Duty::poll);
  role.unwait_behind();
}

TEST_F(ReceivingRoleTest, WakesTheOwnThreadIfAThreadWaitsForAVacantRole) {
  pass_to_waiter();
  EXPECT_EQ(role.enter(now), Entry::occupied);
  role.leave(now);
  EXPECT_TRUE(role.wait_behind());
}

TEST_F(ReceivingRoleTest, IsTakenFromAThreadThatTwiceLeavesDatagramsUnread) {
  pass_to_waiter();
  EXPECT_EQ(duty(true), Duty::stand_by) << "it has just come";
  now += ReceivingRole::second_look;
  EXPECT_TRUE(role.next(now, true).evicts);
  EXPECT_TRUE(role.lost());
  EXPECT_FALSE(role.begin());
  EXPECT_EQ(role.enter(now), Entry::occupied) << "it has not left yet";
  const ReceivingRole::Leaving leaving = role.leave(now);
  EXPECT_FALSE(leaving.wake || leaving.set_alarm);
}

TEST_F(ReceivingRoleTest, IsTakenFromAThreadThatMissesADeadline) {
  pass_to_waiter();
  ASSERT_TRUE(role.begin());
  role.end(now + 5ms);
  EXPECT_EQ(duty(), Duty::stand_by);
  now += 10ms;
  EXPECT_EQ(duty(), Duty::stand_by);
  now += ReceivingRole::second_look;
  EXPECT_TRUE(role.next(now, false).evicts);
}

TEST_F(ReceivingRoleTest, StaysWithAThreadThatReceives) {
  pass_to_waiter();
  for (int i = 0; i < 5; ++i, now += 20ms) {
    EXPECT_EQ(duty(true), Duty::stand_by);
    take_turn();
  }
  ASSERT_TRUE(role.begin());
  for (int i = 0; i < 5; ++i, now += 20ms) EXPECT_EQ(duty(true), Duty::stand_by) << "in the middle of a turn";
}

TEST_F(ReceivingRoleTest, BelongsToTheOwnThreadAloneIfNoOtherMayCallListeners) {
  pass_to_waiter();
  EXPECT_TRUE(role.add_attended()) << "both have to be woken";
  EXPECT_TRUE(role.lost());
  EXPECT_FALSE(role.begin());
  EXPECT_TRUE(role.leave(now).wake);
  EXPECT_EQ(duty(), Duty::receive);
  EXPECT_EQ(role.enter(now), Entry::refused);
  EXPECT_FALSE(role.end_turn(no_deadline));
  role.remove_attended();
  EXPECT_EQ(role.enter(now), Entry::taken);
}

TEST_F(ReceivingRoleTest, IsNotPassedToAThreadThatGaveUpMeanwhile) {
  EXPECT_EQ(duty(), Duty::receive);
  EXPECT_EQ(role.enter(now), Entry::promised);
  EXPECT_FALSE(role.leave(now).set_alarm);
  EXPECT_FALSE(role.end_turn(no_deadline));
  EXPECT_NE(duty(), Duty::stand_by);
}

TEST_F(ReceivingRoleTest, EndsForEveryThreadWithTheTransport) {
  pass_to_waiter();
  role.close();
  EXPECT_EQ(duty(), Duty::stop);
  EXPECT_TRUE(role.lost());
  EXPECT_FALSE(role.begin());
  role.leave(now);
  EXPECT_EQ(role.enter(now), Entry::refused);
}

TEST(SpinLimits, GiveTheLargestLimitOfAllReaders) {
  SpinLimits limits;
  EXPECT_EQ(limits.largest(), 0us);
  limits.add(20us);
  limits.add(1ms);
  limits.add(20us);
  EXPECT_EQ(limits.largest(), 1ms);
  limits.remove(1ms);
  limits.remove(20us);
  EXPECT_EQ(limits.largest(), 20us);
}

}  // namespace
}  // namespace sft::udp
