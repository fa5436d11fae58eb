#include "udp_transport/reliable/room_waiters.h"

#include <gtest/gtest.h>

namespace sft::udp {
namespace {

TEST(RoomWaitersTest, TellsTheSendingThreadOnceIfItWaits) {
  RoomWaiters waiters;
  EXPECT_EQ(waiters.notify(), Wake::none);
  waiters.note_sending_thread(true);
  EXPECT_EQ(waiters.notify(), Wake::look);
  EXPECT_EQ(waiters.notify(), Wake::none) << "the sending thread notes it again if there still is no room";
}

TEST(RoomWaitersTest, TellsTheSendingThreadNothingThatItDoesNotWaitForAnyMore) {
  RoomWaiters waiters;
  waiters.note_sending_thread(true);
  waiters.note_sending_thread(false);
  EXPECT_EQ(waiters.notify(), Wake::none);
}

TEST(RoomWaitersTest, LetsThePublisherGoOnWhenTheTimeIsOver) {
  RoomWaiters waiters;
  core::Mutex mutex;
  core::Lock lock(mutex);
  bool in_time = true;
  while (in_time) in_time = waiters.wait_until(lock, {});
  EXPECT_FALSE(in_time);
}

}  // namespace
}  // namespace sft::udp
