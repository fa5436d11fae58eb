// The lock of a port while the daemon holds it: the daemon was stopped or killed while it changed
// connections.
#include <thread>

#include "shm_transport/daemon/process_daemon.h"
#include "shm_transport/ports/writer_port.h"
#include "tests/transports/shm/shm_fixture.h"

namespace sft::test {
namespace {

using core::SendStatus;

class HeldLock : public ShmNodeTest {
 protected:
  void SetUp() override {
    ShmNodeTest::SetUp();
    if (IsSkipped() || HasFatalFailure()) return;
    session_ = shm::ProcessDaemon::shared()->advance(own_daemon(), Clock::now()).session;
    publisher_ = session_->create_publisher(1, {hang_timeout, hang_timeout}).value();
    auto* keeper = session_->create_subscriber(1, 0, {hang_timeout, hang_timeout}).value();
    port_ = shm::ShmWriterPort::make(session_, *publisher_, *keeper, {.id = 1, .type = &frame_type()}, 16,
                                     std::make_shared<shm::DoorbellPages>(), statistics_);
    port_->set_routes(
        {{.reader = reader_id, .destination = core::DoorbellAddress{}, .selection = frame_type().full()}});
  }
  void TearDown() override {
    port_.reset();
    session_.reset();
    ShmNodeTest::TearDown();
  }

  SendStatus send() {
    const core::SampleHandle sample = port_->loan(frame_bytes(100));
    write_frame(*sample, 1, 1, 100);
    return port_->send(sample);
  }

  std::shared_ptr<shm::Session> session_;
  iox::popo::PublisherPortData* publisher_ = nullptr;
  std::shared_ptr<shm::Statistics> statistics_ = std::make_shared<shm::Statistics>();
  std::shared_ptr<shm::ShmWriterPort> port_;
};

TEST_F(HeldLock, CostsAWriterItsSampleAndDoesNotBlockIt) {
  std::thread([this] { publisher_->m_chunkSenderData.lock(); }).join();
  for (std::uint64_t refused = 1; refused <= 20; ++refused) {
    const auto begin = Clock::now();
    EXPECT_EQ(send(), SendStatus::dropped);
    EXPECT_LT(Clock::now() - begin, hang_timeout);
    EXPECT_EQ(statistics_->over_limit, refused);
  }
}

// Each send begins while the lock is held. The sample may be dropped only if the thread with the lock did not
// get the processor for longer than a writer waits.
TEST_F(HeldLock, IsWaitedForWhileItIsHeldForMicroseconds) {
  constexpr auto shortest_wait = 1ms;
  int waited = 0;
  for (int i = 0; i < 300; ++i) {
    std::atomic<bool> held{false};
    Clock::duration held_for{};
    std::thread other([&] {
      publisher_->m_chunkSenderData.lock();
      const auto begin = Clock::now();
      held = true;
      held.notify_one();
      while (Clock::now() < begin + 100us) continue;
      publisher_->m_chunkSenderData.unlock();
      held_for = Clock::now() - begin;
    });
    held.wait(false);
    const SendStatus status = send();
    other.join();
    if (held_for >= shortest_wait) continue;
    EXPECT_EQ(status, SendStatus::sent) << "the lock was held for " << held_for / 1us << " us";
    ++waited;
  }
  EXPECT_GT(waited, 30);
}

// The writer of the queue still runs, so the daemon does not open the lock.
TEST_F(HeldLock, IsOnlyLookedAtByAReaderThatGivesItsPortBack) {
  auto* port = session_->create_subscriber(1, 1, {hang_timeout, hang_timeout}).value();
  ASSERT_TRUE(eventually([&] { return session_->feeder_of(*port) == publisher_; }));
  iox::popo::SubscriberPortUser(port).unsubscribe();
  ASSERT_TRUE(eventually([&] { return session_->feeder_of(*port) == nullptr; }));
  ASSERT_EQ(port->m_subscriptionState.load(), iox::SubscribeState::NOT_SUBSCRIBED);
  port->m_chunkReceiverData.lock();  // the lock is recursive, so this thread could take the lock again
  session_->retire(port);
  session_->collect();
  EXPECT_FALSE(port->m_toBeDestroyed);
  port->m_chunkReceiverData.unlock();
  session_->collect();
  EXPECT_TRUE(port->m_toBeDestroyed);
}

}  // namespace
}  // namespace sft::test
