#include "udp_transport/reliable/channel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <thread>
#include <vector>

#include "tests/support/eventually.h"
#include "tests/unit/udp/connections.h"
#include "tests/unit/udp/jobs.h"
#include "udp_transport/flow/destination_directory.h"

namespace sft::udp {
namespace {

using namespace std::chrono_literals;

// The size of a large sample in bytes. Two such samples exceed a processor's caches.
constexpr std::size_t beyond_caches = 5'000'000;

class ChannelTest : public testing::Test {
 protected:
  JobHandle job(std::size_t bytes) {
    JobHandle made = jobs->take();
    made->pack(std::vector<std::byte>(bytes));
    made->seal();
    return made;
  }
  Channel::Posted post(std::size_t bytes) {
    const JobHandle posted = job(bytes);
    return channel.post(posted, posted->first, false, &hang_timeout);
  }
  void post_at_once(std::size_t bytes) {
    const JobHandle posted = job(bytes);
    static_cast<void>(channel.post(posted, posted->first, false));
  }
  void ack(std::uint64_t next) {
    while (const auto piece = channel.next(ResendWindow::Size::large))
      static_cast<void>(channel.finished(*piece, {}));
    static_cast<void>(channel.hear({.writer = 7, .channel = 3, .next = next}));
  }

  std::chrono::nanoseconds hang_timeout = 60s;
  std::shared_ptr<JobPool> jobs = JobPool::make();
  test::Connections connections;
  DestinationDirectory destinations{{}, connections.connect()};
  Channel channel{7, 3, destinations.find({.ip = 1, .port = 1}), std::make_shared<WriterTally>(), 5000};
};

TEST_F(ChannelTest, HoldsUpForAMomentWhoWouldRunAheadOfTheCaches) {
  EXPECT_FALSE(post(beyond_caches).waited);
  EXPECT_FALSE(post(beyond_caches).waited) << "one is encoded while the other one is sent";
  EXPECT_EQ(hang_timeout, 60s);
  const Channel::Posted third = post(beyond_caches);
  EXPECT_TRUE(third.waited);
  EXPECT_EQ(third.kept.ordinal, 3u);
  EXPECT_EQ(third.kept.dropped, 0u);
  EXPECT_LT(hang_timeout, 60s);
  EXPECT_GT(hang_timeout, 30s) << "nothing is lost by going on";
}

TEST_F(ChannelTest, HoldsUpNobodyOnceWhatWasSentIsAcknowledged) {
  post(beyond_caches);
  post(beyond_caches);
  ack(2);
  EXPECT_FALSE(post(beyond_caches).waited);
}

TEST_F(ChannelTest, HoldsUpNoPublisherThatMayNotWait) {
  hang_timeout = 0ns;
  post(beyond_caches);
  post(beyond_caches);
  const JobHandle third = job(beyond_caches);
  EXPECT_FALSE(channel.post(third, third->first, false).waited);
}

TEST_F(ChannelTest, HoldsUpNoSmallSamples) {
  for (int i = 0; i < 1000; ++i) ASSERT_FALSE(post(1000).waited) << i;
}

TEST_F(ChannelTest, UsesUpTheTimeoutBeforeSamplesAreLost) {
  bool lost = false;
  for (int i = 0; i < 20 && !lost; ++i) {
    hang_timeout = 20ms;
    lost = post(beyond_caches).kept.dropped > 0;
  }
  EXPECT_TRUE(lost);
  EXPECT_EQ(hang_timeout, 0ns);
}

TEST_F(ChannelTest, HoldsUpNobodyAnyMoreOnceAcksAreOfWhatWasNeverSent) {
  while (channel.await_room(*job(beyond_caches), nullptr)) post_at_once(beyond_caches);
  const Ack impossible{.writer = 7, .channel = 3, .next = 1'000};
  static_cast<void>(channel.hear(impossible));
  EXPECT_FALSE(channel.went_wrong()) << "one may be forged";
  std::atomic<bool> waits = false;
  std::jthread publisher([&] {
    waits = true;
    post(beyond_caches);
  });
  const auto a_while = std::chrono::steady_clock::now() + 50ms;
  ASSERT_TRUE(sft::test::eventually([&] { return waits && std::chrono::steady_clock::now() > a_while; }));
  static_cast<void>(channel.hear(impossible));
  EXPECT_TRUE(channel.went_wrong());
  publisher.join();
  EXPECT_GT(hang_timeout, 30s);
}

class ChannelOfFewBytesTest : public ChannelTest {
 protected:
  /// Posts samples without waiting, and returns the number of those that the channel keeps.
  std::uint64_t kept_of(int samples, std::size_t bytes) {
    std::uint64_t last = 0;
    for (int i = 0; i < samples; ++i) {
      const JobHandle posted = job(bytes);
      last = few_.post(posted, posted->first, false).kept.ordinal;
    }
    std::uint64_t kept = 0;
    while (last > kept && few_.keeps(last - kept)) ++kept;
    return kept;
  }

 private:
  Channel few_{7, 3, destinations.find({.ip = 1, .port = 1}),
               std::make_shared<WriterTally>(0, std::int8_t{0}, ResendLimits::of_at_most(1'000'000)), 5000};
};

TEST_F(ChannelOfFewBytesTest, KeepsNoMoreBytesThanItsWriterAllows) {
  const std::uint64_t kept = kept_of(100, 100'000);
  EXPECT_GE(kept, 8U);
  EXPECT_LE(kept, 10U);
}

TEST_F(ChannelOfFewBytesTest, KeepsThreeSamplesHoweverLargeTheyAre) {
  EXPECT_EQ(kept_of(10, beyond_caches), 3U);
}

class ChannelHeartbeatTest : public testing::Test {
 protected:
  /// Sends a sample at that time, as the publisher's thread does.
  void send(std::uint64_t sequence, Channel::Time at) {
    const JobHandle job = test::make_job(*jobs_, sequence);
    const Channel::Posted posted = channel_.post(job, job->first, true);
    ASSERT_TRUE(posted.piece);
    static_cast<void>(channel_.finished(*posted.piece, at));
  }
  static Ack ack(std::uint64_t next) { return {.writer = 1, .channel = 1, .next = next}; }
  static Ack asking_for(std::uint32_t ordinal, std::uint64_t next) {
    Ack asking = ack(next);
    asking.missing[asking.missing_count++] = {ordinal, 0, 0};
    return asking;
  }

  std::shared_ptr<JobPool> jobs_ = JobPool::make();
  test::Connections connections_;
  DestinationDirectory destinations_{{}, connections_.connect()};
  Channel channel_{1, 1, destinations_.find({.ip = 0x7F000001, .port = 1}), std::make_shared<WriterTally>(),
                   7};
  Channel::Time now_ = std::chrono::steady_clock::now();
};

TEST_F(ChannelHeartbeatTest, PartsWhereAcksAreOfWhatWasNeverSent) {
  send(1, now_);
  static_cast<void>(channel_.hear(ack(9)));
  EXPECT_FALSE(channel_.went_wrong());
  EXPECT_EQ(channel_.hear(ack(10)), Wake::look) << "the sending thread has to look";
  EXPECT_TRUE(channel_.went_wrong());
  const Channel::Care care = channel_.look_after();
  ASSERT_TRUE(care.heartbeat);
  EXPECT_EQ(care.heartbeat->first, care.heartbeat->end) << "nothing is left";
  EXPECT_TRUE(care.at_rest);
  EXPECT_EQ(channel_.tally().dropped, 1U);
  EXPECT_FALSE(channel_.look_after().heartbeat);
}

TEST_F(ChannelHeartbeatTest, WakesASendingThreadThatLookedWhileNothingHadLeft) {
  send(1, now_);
  static_cast<void>(channel_.hear(ack(2)));
  const JobHandle job = test::make_job(*jobs_, 2);
  const Channel::Posted posted = channel_.post(job, job->first, true);
  EXPECT_EQ(posted.wake, Wake::none) << "it is attended to, and its publisher sends";
  EXPECT_EQ(channel_.look_after().next_look, Channel::Time::max());
  EXPECT_EQ(channel_.finished(*posted.piece, now_), Wake::look) << "if it gets lost, nobody asks for it";
}

TEST_F(ChannelHeartbeatTest, WakesTheSendingThreadForAHeartbeatThatIsDueSooner) {
  send(1, now_);
  EXPECT_TRUE(channel_.look_after().heartbeat);
  send(2, now_ + 1h);
  EXPECT_EQ(channel_.hear(ack(2)), Wake::none);
  EXPECT_GT(channel_.look_after().next_look, now_ + 30min);
  EXPECT_EQ(channel_.hear(asking_for(1, 2)), Wake::look) << "it is gone, and that has to be said";
  EXPECT_EQ(channel_.hear(asking_for(1, 2)), Wake::none) << "it is awake";
  EXPECT_LT(channel_.look_after().next_look, now_ + 30min);
}

}  // namespace
}  // namespace sft::udp
