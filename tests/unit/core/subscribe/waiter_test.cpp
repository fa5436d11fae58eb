// Tests how a thread waits for samples, and when a subscriber's file descriptor is readable.
#include "core/subscribe/waiter.h"

#include <gtest/gtest.h>
#include <poll.h>

#include <atomic>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <thread>

#include "core/seam/buffer_pool.h"
#include "tests/unit/core/seam/queue_port.h"

namespace sft::core {
namespace {

using namespace detail;

using namespace std::chrono_literals;
using sensor_msgs::msg::PointCloud2;

class WaiterTest : public ::testing::Test {
 protected:
  WaiterTest() {
    ports.set_memory(memory);
    EXPECT_GE(polled.descriptor(), 0) << "a program watches it";
  }

  void arrives(std::uint64_t sequence) {
    SampleHandle sample = pool->take(256);
    sample->writer = 9;
    sample->sequence = sequence;
    memory->samples.push_back(std::move(sample));
  }
  bool is_readable() const {
    pollfd waits{.fd = polled.descriptor(), .events = POLLIN, .revents = 0};
    return ::poll(&waits, 1, 0) == 1;
  }
  static Time now() { return std::chrono::steady_clock::now(); }

  const TypeSupport type{TypeTable<PointCloud2>::type};
  const std::shared_ptr<BufferPool> pool = BufferPool::make(1 << 20);
  const std::shared_ptr<MemoryQueue> memory = std::make_shared<MemoryQueue>();
  const std::unique_ptr<DoorbellPage> bells = DoorbellPage::create();
  const std::unique_ptr<PollHandle> handle = PollHandle::create().value();
  Doorbell& bell = bells->at(0);
  SubscriberPorts ports{{}, make_asked(type, type.full(), false, nullptr), false};
  std::atomic<bool> interrupted{false};
  Waiter waiter{{&ports}, bell, nullptr, 0ns, &interrupted};
  Waiter polled{{&ports}, bell, handle.get(), 0ns, &interrupted};
};

TEST_F(WaiterTest, ReturnsAtOnceIfThereIsASample) {
  arrives(1);
  EXPECT_TRUE(waiter.wait_until(now() + 1h));
  EXPECT_TRUE(polled.wait_until(now() + 1h));
}

TEST_F(WaiterTest, ReturnsAtTheDeadlineIfThereIsNone) {
  const Time deadline = now() + 5ms;
  EXPECT_FALSE(waiter.wait_until(deadline));
  EXPECT_GE(now(), deadline);
  EXPECT_FALSE(polled.wait_until(now() + 5ms));
}

TEST_F(WaiterTest, AnInterruptEndsAWaitThatHasNoSampleNowAndFromNowOn) {
  std::thread waits([this] { EXPECT_FALSE(waiter.wait_until(Time::max())); });
  interrupted = true;
  bell.ring();
  waits.join();
  EXPECT_FALSE(waiter.wait_until(Time::max()));
  arrives(1);
  EXPECT_TRUE(waiter.wait_until(Time::max()));
}

TEST_F(WaiterTest, TheDescriptorStaysReadableAfterAnInterrupt) {
  polled.show_if_available();
  EXPECT_FALSE(is_readable());
  interrupted = true;
  EXPECT_TRUE(polled.has_unshown());
  polled.show_if_available();
  EXPECT_TRUE(is_readable());
  EXPECT_FALSE(polled.wait_until(Time::max()));
  polled.taken();
  EXPECT_TRUE(is_readable());
}

TEST_F(WaiterTest, OnlyASubscriberWithAHandleHasADescriptor) {
  EXPECT_FALSE(waiter.has_descriptor());
  EXPECT_EQ(waiter.descriptor(), -1);
  EXPECT_TRUE(polled.has_descriptor());
  EXPECT_GE(polled.descriptor(), 0);
}

TEST_F(WaiterTest, AnArrivalRingsTheDoorbellOrMakesTheDescriptorReadable) {
  const std::uint32_t rings = bell.rings;
  polled.sample_arrived();
  EXPECT_TRUE(is_readable());
  EXPECT_EQ(bell.rings, rings);
  waiter.sample_arrived();
  EXPECT_EQ(bell.rings, rings + 1);
}

TEST_F(WaiterTest, TheDescriptorIsReadableWhileThereIsASample) {
  EXPECT_FALSE(polled.has_unshown());
  polled.show_if_available();
  EXPECT_FALSE(is_readable());
  arrives(1);
  EXPECT_TRUE(polled.has_unshown());
  polled.show_if_available();
  EXPECT_TRUE(is_readable());
  EXPECT_FALSE(polled.has_unshown());
  polled.taken();
  EXPECT_TRUE(is_readable()) << "nothing was taken yet";
  ports.take();
  polled.taken();
  EXPECT_FALSE(is_readable());
}

TEST_F(WaiterTest, ADescriptorThatNoProgramWatchesIsLoweredByWaitsOnly) {
  const std::unique_ptr<PollHandle> own = PollHandle::create().value();
  Waiter unwatched{{&ports}, bell, own.get(), 0ns, &interrupted};
  const auto comes_and_is_taken = [&](std::uint64_t sequence) {
    arrives(sequence);
    unwatched.show_if_available();
    ports.take();
    unwatched.taken();
    return own->is_raised();
  };
  EXPECT_TRUE(comes_and_is_taken(1));
  EXPECT_FALSE(unwatched.wait_until(now() + 1ms)) << "it sleeps nevertheless";
  EXPECT_FALSE(own->is_raised());
  EXPECT_TRUE(comes_and_is_taken(2));
  pollfd waits{.fd = unwatched.descriptor(), .events = POLLIN, .revents = 0};
  EXPECT_EQ(::poll(&waits, 1, 0), 0) << "the descriptor is right again once a program asks for it";
  EXPECT_FALSE(comes_and_is_taken(3));
}

}  // namespace
}  // namespace sft::core
