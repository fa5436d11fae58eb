// The locks that sftd opens by force. The ports lie in the memory of this process.
#include "shm_transport/sftd/lock_healer.h"

#include <gtest/gtest.h>

#include <iceoryx_posh/roudi/port_pool.hpp>
#include <memory>
#include <thread>

#include "tests/support/eventually.h"

namespace sft::test {
namespace {

/// Has a port of a process that is not registered, and so counts as dead.
class LockHealerTest : public ::testing::Test {
 protected:
  LockHealerTest() { healer_.note_ports(); }
  ~LockHealerTest() override {
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
  shm::LockHealer healer_{pool_, clients_, log_};
};

TEST_F(LockHealerTest, OpensALockAtOnceThatNoThreadOfTheDaemonHolds) {
  std::thread([this] { lock().lock(); }).join();
  EXPECT_TRUE(healer_.heal());
  EXPECT_FALSE(shm::is_closed(lock()));
  EXPECT_EQ(healer_.opened(), 1U);
}

TEST_F(LockHealerTest, OpensALockInTheEndThatAThreadOfTheDaemonSeemsToHold) {
  lock().lock();  // a thread with the same id in another pid namespace would leave the lock like this
  EXPECT_FALSE(healer_.heal()) << "the holder may be a thread of the daemon";
  EXPECT_TRUE(shm::is_closed(lock()));
  EXPECT_TRUE(eventually([this] { return healer_.heal() && !shm::is_closed(lock()); }));
}

TEST_F(LockHealerTest, LeavesALockAloneThatAThreadOfTheDaemonHoldsAgainAndAgain) {
  for (int i = 0; i < 10'000; ++i) {
    lock().lock();
    healer_.heal();
    ASSERT_TRUE(shm::is_closed(lock())) << i;
    lock().unlock();
    healer_.heal();  // most looks of a healer that looks every 20 ms find the lock open
  }
}

// A program of which the daemon knows no port yet may have begun to deliver into this queue.
TEST_F(LockHealerTest, LeavesTheLockOfAQueueWithoutAKnownWriterTimeToBeReleased) {
  auto& queue = *pool_.addSubscriberPort({"sft", "late", "1"}, "sft_dead", {}).value();
  healer_.note_ports();
  const auto& queue_lock = queue.m_chunkReceiverData;
  std::thread([&] { queue.m_chunkReceiverData.lock(); }).join();
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_FALSE(healer_.heal()) << "its holder may be alive";
  EXPECT_TRUE(eventually([&] { return healer_.heal() && !shm::is_closed(queue_lock); }));
  EXPECT_GE(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds(100));
}

}  // namespace
}  // namespace sft::test
