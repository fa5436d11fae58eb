#include "udp_transport/send/sender.h"

#include <gtest/gtest.h>

#include <condition_variable>
#include <future>
#include <mutex>
#include <set>
#include <vector>

#include "tests/support/eventually.h"
#include "tests/unit/udp/jobs.h"
#include "udp_transport/flow/destination_directory.h"

namespace sft::udp {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

/// Connections whose send buffers are always full. `Seen` records whether the sending thread waits for a
/// connection that was closed.
class FullIo final : public DatagramSender {
 public:
  struct Seen {
    std::set<const Connection*> open;
    std::vector<const Connection*> waiting;
    std::function<void()> when_one_waits;
    std::promise<void> one_closed;
    bool is_one_closed = false;
    std::size_t awaited_closed = 0;
  };
  explicit FullIo(Seen& seen) : seen_(seen) {}

  std::unique_ptr<Connection> connect(const SocketAddress&) override { return std::make_unique<Full>(seen_); }
  std::unique_ptr<Connection> connect_group(const SocketAddress& group, const SocketAddress&) override {
    return connect(group);
  }
  void await(Clock::time_point deadline) noexcept override {
    for (const Connection* connection : seen_.waiting)
      seen_.awaited_closed += seen_.open.contains(connection) ? 0 : 1;
    seen_.waiting.clear();
    std::unique_lock lock(mutex_);
    const auto woken = [this] { return std::exchange(woken_, false); };
    deadline == Clock::time_point::max() ? woken_up_.wait(lock, woken)
                                         : void(woken_up_.wait_until(lock, deadline, woken));
  }
  void send_to(const SocketAddress&, std::span<const std::byte>) noexcept override {}
  void wake() noexcept override {
    const std::scoped_lock lock(mutex_);
    woken_ = true;
    woken_up_.notify_one();
  }

 private:
  class Full final : public Connection {
   public:
    explicit Full(Seen& seen) : seen_(seen) { seen_.open.insert(this); }
    ~Full() override {
      seen_.open.erase(this);
      if (!std::exchange(seen_.is_one_closed, true)) seen_.one_closed.set_value();
    }
    Sent try_send(std::span<const OutgoingBatch>) noexcept override { return {0, SendOutcome::would_wait}; }
    void reconnect() noexcept override {}
    void redirect(const SocketAddress&) noexcept override {}
    void wait_for_room() noexcept override {
      seen_.waiting.push_back(this);
      seen_.when_one_waits();
    }
    bool full() const noexcept override { return false; }

   private:
    Seen& seen_;
  };

  Seen& seen_;
  std::mutex mutex_;
  std::condition_variable woken_up_;
  bool woken_ = false;
};

TEST(SenderTest, WaitsForNoConnectionOfAChannelThatIsAtRest) {
  const auto jobs = JobPool::make();
  FullIo::Seen seen;
  Sender sender(std::make_unique<FullIo>(seen));
  DestinationDirectory destinations({}, [&](const SocketAddress& to) { return sender.connect(to); });
  auto channel = std::make_shared<Channel>(1, 1, destinations.find({.ip = 0x7F000001, .port = 1}),
                                           std::make_shared<WriterTally>(), 7);
  const std::weak_ptr<Channel> same = channel;
  seen.when_one_waits = [same] {  // The last sample of the channel is acknowledged meanwhile.
    if (const auto known = same.lock())
      static_cast<void>(known->hear({.writer = 1, .channel = 1, .next = 2}));
  };
  const JobHandle job = test::make_job(*jobs, 1);
  channel->post(job, job->first, false);
  sender.schedule(std::move(channel));
  ASSERT_TRUE(sender.start("sender"));
  EXPECT_EQ(seen.one_closed.get_future().wait_for(sft::test::hang_timeout), std::future_status::ready);
  sender.stop();
  EXPECT_EQ(seen.awaited_closed, 0U);
}

TEST(SenderTest, GivesLargeSamplesOfTheGreaterPriorityTheFirstTurn) {
  const auto jobs = JobPool::make();
  FullIo::Seen seen;
  Sender sender(std::make_unique<FullIo>(seen));
  DestinationDirectory destinations({}, [&](const SocketAddress& to) { return sender.connect(to); });
  const auto channel_with_large_sample = [&](std::uint16_t port, std::int8_t priority) {
    auto channel = std::make_shared<Channel>(1, port, destinations.find({.ip = 0x7F000001, .port = port}),
                                             std::make_shared<WriterTally>(0, priority), 7);
    const JobHandle job = test::make_job(*jobs, 1, 100'000);
    channel->post(job, job->first, false);
    return channel;
  };
  std::promise<std::vector<const Connection*>> round;
  bool is_set = false;
  seen.when_one_waits = [&] {
    if (seen.waiting.size() == 2 && !std::exchange(is_set, true)) round.set_value(seen.waiting);
  };
  // The first round would begin with the second channel.
  const auto urgent = channel_with_large_sample(1, 1);
  const auto usual = channel_with_large_sample(2, 0);
  sender.schedule(urgent);
  sender.schedule(usual);
  ASSERT_TRUE(sender.start("sender"));
  auto waited = round.get_future();
  ASSERT_EQ(waited.wait_for(sft::test::hang_timeout), std::future_status::ready);
  sender.stop();
  EXPECT_EQ(waited.get(),
            (std::vector<const Connection*>{&urgent->destination().bulk(), &usual->destination().bulk()}));
}

}  // namespace
}  // namespace sft::udp
