// Which locks sftd opens by force. The ports lie in this process's own memory.
#include "shm_transport/sftd/lock_healer.h"

#include <gtest/gtest.h>

#include <iceoryx_posh/roudi/port_pool.hpp>
#include <memory>
#include <thread>

#include "tests/support/eventually.h"

namespace sft::test {
namespace {

/// A port of a process that nobody knows, so it counts as dead.
class LockHealerTest : public ::testing::Test {
 protected:
  LockHealerTest() { healer_.note_ports(); }
  ~LockHealerTest() override {
    if (shm::is_closed(lock())) lock().unlock();  // a closed one cannot be destroyed
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

TEST_F(LockHealerTest, OpensAtOnceWhatNoThreadOfTheDaemonHolds) {
  std::thread([this] { lock().lock(); }).join();
  EXPECT_TRUE(healer_.heal());
  EXPECT_FALSE(shm::is_closed(lock()));
  EXPECT_EQ(healer_.opened(), 1U);
}

TEST_F(LockHealerTest, OpensInTheEndWhatAThreadOfTheDaemonSeemsToHold) {
  lock().lock();  // as one of the same id in another pid namespace would have
  EXPECT_FALSE(healer_.heal()) << "it may be one of the daemon's after all";
  EXPECT_TRUE(shm::is_closed(lock()));
  EXPECT_TRUE(eventually([this] { return healer_.heal() && !shm::is_closed(lock()); }));
}

TEST_F(LockHealerTest, LeavesALockAloneThatAThreadOfTheDaemonHoldsAgainAndAgain) {
  for (int i = 0; i < 10'000; ++i) {
    lock().lock();
    healer_.heal();
    ASSERT_TRUE(shm::is_closed(lock())) << i;
    lock().unlock();
    healer_.heal();  // as one that comes every 20 ms: most find it open
  }
}

}  // namespace
}  // namespace sft::test
