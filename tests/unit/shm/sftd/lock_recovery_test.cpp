// The locks that sftd opens by force. The ports are in the memory of this process.
#include "shm_transport/sftd/lock_recovery.h"

#include <gtest/gtest.h>

#include <iceoryx_posh/roudi/port_pool.hpp>
#include <memory>
#include <thread>

#include "tests/support/eventually.h"

namespace sft::test {
namespace {

/// A port of a process that is not registered, so that the process counts as dead.
class LockRecoveryTest : public ::testing::Test {
 protected:
  LockRecoveryTest() { lock_recovery_.note_ports(); }
  ~LockRecoveryTest() override {
    if (shm::is_closed(lock())) lock().unlock();  // a closed lock cannot be destroyed
  }

  shm::PortLock& lock() { return port_.m_chunkSenderData; }
  const shm::Log log_{shm::LogLevel::error, shm::Log::Target::standard_error};
  shm::ClientTable clients_;
  iox::mepoo::MemoryManager memory_;
  const std::unique_ptr<iox::roudi::PortPoolData> ports_ = std::make_unique<iox::roudi::PortPoolData>();
  iox::roudi::PortPool pool_{*ports_};
  iox::popo::PublisherPortData& port_ =
      *pool_.addPublisherPort({"sft", "w", "1"}, &memory_, "sft_dead", {}).value();
  shm::LockRecovery lock_recovery_{pool_, clients_, log_};
};

TEST_F(LockRecoveryTest, OpensALockAtOnceThatNoThreadOfTheDaemonHolds) {
  std::thread([this] { lock().lock(); }).join();
  EXPECT_TRUE(lock_recovery_.recover());
  EXPECT_FALSE(shm::is_closed(lock()));
  EXPECT_EQ(lock_recovery_.opened(), 1U);
}

TEST_F(LockRecoveryTest, OpensALockInTheEndThatAThreadOfTheDaemonSeemsToHold) {
  // A killed thread with the same id in another pid namespace would leave the lock in this state.
  lock().lock();
  EXPECT_FALSE(lock_recovery_.recover()) << "the holder may be a thread of the daemon";
  EXPECT_TRUE(shm::is_closed(lock()));
  EXPECT_TRUE(eventually([this] { return lock_recovery_.recover() && !shm::is_closed(lock()); }));
}

TEST_F(LockRecoveryTest, LeavesALockAloneThatAThreadOfTheDaemonHoldsAgainAndAgain) {
  for (int i = 0; i < 10'000; ++i) {
    lock().lock();
    lock_recovery_.recover();
    ASSERT_TRUE(shm::is_closed(lock())) << i;
    lock().unlock();
    lock_recovery_.recover();  // most checks, one each 20 ms, find the lock open
  }
}

// A program may have begun to deliver into this queue before the daemon has noted the program's port.
TEST_F(LockRecoveryTest, LeavesTheLockOfAQueueWithoutAKnownWriterTimeToBeReleased) {
  auto& queue = *pool_.addSubscriberPort({"sft", "late", "1"}, "sft_dead", {}).value();
  lock_recovery_.note_ports();
  const auto& queue_lock = queue.m_chunkReceiverData;
  std::thread([&] { queue.m_chunkReceiverData.lock(); }).join();
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_FALSE(lock_recovery_.recover()) << "its holder may be alive";
  EXPECT_TRUE(eventually([&] { return lock_recovery_.recover() && !shm::is_closed(queue_lock); }));
  EXPECT_GE(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds(100));
}

}  // namespace
}  // namespace sft::test
