// No wake-up is ever lost. In each round one side publishes while the other side begins to wait, at random
// times. A thread that is not woken waits until a deadline that only a lost wake-up reaches.
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <optional>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <thread>

#include "core/platform/doorbell.h"
#include "core/seam/buffer_pool.h"
#include "core/subscribe/dispatcher.h"
#include "core/subscribe/subscriber_core.h"
#include "tests/support/random_moment.h"
#include "tests/support/test_seed.h"
#include "tests/unit/core/seam/queue_port.h"

namespace sft::core {
namespace {

using namespace detail;

using namespace std::chrono_literals;
using sensor_msgs::msg::PointCloud2;
using test::comes_to;
using test::RandomMoment;
using Clock = std::chrono::steady_clock;

constexpr auto much_later = 10s;
#ifndef SFT_TEST_SHARE
#define SFT_TEST_SHARE 1
#endif
/// Returns the number of rounds to run. Under the sanitizers it is only a part of the usual number.
std::uint64_t rounds_of(std::uint64_t usual) { return test::test_rounds(usual / SFT_TEST_SHARE); }

class WakeUp : public test::RandomTest {};

/// Waits for a sample of the round. Returns false if no ring has woken this thread in time.
bool is_woken_for(Doorbell& bell, const std::atomic<std::uint32_t>& published, std::uint32_t round) {
  while (published < round) {
    const auto begun = Clock::now();
    bell.wait(begun + much_later, [&] { return published >= round; });
    if (Clock::now() - begun >= much_later) return false;
  }
  return true;
}

TEST_F(WakeUp, OfTwoSleepersOnOneDoorbellIsNeverLost) {
  const auto page = DoorbellPage::create();
  Doorbell& bell = page->at(0);
  const auto rounds = static_cast<std::uint32_t>(rounds_of(15'000));
  std::atomic<std::uint32_t> published{0};
  std::array<std::atomic<std::uint32_t>, 2> woken{};
  const auto sleep = [&](std::size_t which) {
    RandomMoment moment(which);
    for (std::uint32_t round = 1; round <= rounds; ++round) {
      moment.pass();
      ASSERT_TRUE(is_woken_for(bell, published, round)) << "round " << round;
      woken[which] = round;
    }
  };
  std::thread one(sleep, 0), two(sleep, 1);
  RandomMoment moment(2);
  for (std::uint32_t round = 1; round <= rounds; ++round) {
    moment.pass();
    published = round;
    bell.ring();
    if (!comes_to(woken[0], round) || !comes_to(woken[1], round)) break;
  }
  one.join();
  two.join();
  EXPECT_EQ(published, rounds);
}

TEST_F(WakeUp, ByAnotherProcessIsNeverLost) {
  const auto page = DoorbellPage::create();
  if (page->id() == 0) GTEST_SKIP() << "/dev/shm cannot be used here";
  const auto rounds = static_cast<std::uint32_t>(rounds_of(10'000));
  Doorbell& bell = page->at(0);
  // Any word that both processes can access is suitable.
  std::atomic<std::uint32_t>& published = page->at(1).rings;
  std::atomic<std::uint32_t>& woken = page->at(2).rings;
  const pid_t child = fork();
  if (child == 0) {
    RandomMoment moment(1);
    for (std::uint32_t round = 1; round <= rounds; ++round) {
      moment.pass();
      published = round;
      bell.ring();
      if (!comes_to(woken, round)) _exit(1);
    }
    _exit(0);
  }
  RandomMoment moment(0);
  for (std::uint32_t round = 1; round <= rounds; ++round) {
    moment.pass();
    EXPECT_TRUE(is_woken_for(bell, published, round)) << "round " << round;
    if (HasFailure()) break;
    woken = round;
  }
  int status = -1;
  waitpid(child, &status, 0);
  EXPECT_EQ(status, 0);
}

/// A whole subscriber, which gets samples by both transports as in a program.
class SubscriberWakeUp : public WakeUp {
 protected:
  void open(std::chrono::nanoseconds spin, std::unique_ptr<PollHandle> poll_handle = nullptr) {
    SubscriberCore::Spec spec;
    spec.type = &type_;
    spec.feeds = {{.id = 1, .selection = type_.full()}};
    spec.options.spin = spin;
    spec.poll_handle = std::move(poll_handle);
    subscriber_ = std::make_shared<SubscriberCore>(std::move(spec), bell(), nullptr);
    subscriber_->ports().set_memory(memory_);
    subscriber_->ports().set_network(network_);
  }

  /// Publishes one sample per round on another thread, while `receive` takes the samples on this thread.
  template <class Receive>
  void exchange(std::uint64_t rounds, Receive receive) {
    std::thread publisher([&] {
      RandomMoment moment(1);
      for (std::uint64_t round = 1; round <= rounds; ++round) {
        moment.pass();
        publish(round);
        if (!comes_to(taken_, round)) return;
      }
    });
    RandomMoment moment(0);
    for (std::uint64_t round = 1; round <= rounds && !HasFailure(); ++round) {
      moment.pass();
      round_ = round;
      EXPECT_TRUE(receive()) << "round " << round;
      end_round();
    }
    publisher.join();
  }

  /// Lets the other thread publish the next sample.
  void end_round() { taken_ = round_; }

  SubscriberCore& subscriber() { return *subscriber_; }
  const std::shared_ptr<SubscriberCore>& shared() { return subscriber_; }
  Doorbell& bell() { return bells_->at(0); }

 private:
  void publish(std::uint64_t sequence) {
    SampleHandle sample = pool_->take(256);
    sample->writer = 9;
    sample->sequence = sequence;
    const bool in_memory = sequence % 3 != 0;
    if (in_memory) {
      memory_->put(std::move(sample));
      bell().ring();
    } else {
      network_->put(std::move(sample));
      subscriber_->arrived();
    }
  }

  const TypeSupport type_{TypeTable<PointCloud2>::type};
  const std::unique_ptr<DoorbellPage> bells_ = DoorbellPage::create();
  const std::shared_ptr<BufferPool> pool_ = BufferPool::make(1 << 20);
  const std::shared_ptr<SharedMemoryQueue> memory_ = std::make_shared<SharedMemoryQueue>();
  const std::shared_ptr<SharedNetworkQueue> network_ = std::make_shared<SharedNetworkQueue>();
  std::shared_ptr<SubscriberCore> subscriber_;
  std::atomic<std::uint64_t> taken_{0};
  std::uint64_t round_ = 0;
};

TEST_F(SubscriberWakeUp, FromSleepIsNeverLost) {
  open(0ns);
  exchange(rounds_of(15'000), [&] { return subscriber().wait(much_later) && subscriber().take(); });
}

TEST_F(SubscriberWakeUp, BetweenSpinningAndSleepIsNeverLost) {
  open(2us);
  exchange(rounds_of(10'000), [&] { return subscriber().wait(much_later) && subscriber().take(); });
}

TEST_F(SubscriberWakeUp, ByFileDescriptorIsNeverLostAndItIsReadableOnlyWhileThereIsASample) {
  open(0ns, PollHandle::create().value());
  std::optional<Dispatcher> poller(std::in_place, bell(), "test");
  poller->add(shared());
  ASSERT_TRUE(poller->start());
  const auto becomes_readable = [&](std::chrono::milliseconds within) {
    pollfd waits{.fd = subscriber().file_descriptor(), .events = POLLIN, .revents = 0};
    return ::poll(&waits, 1, static_cast<int>(within.count())) == 1;
  };
  exchange(rounds_of(10'000), [&] {
    while (becomes_readable(much_later)) {
      end_round();  // lets the next sample arrive while this one is taken and the descriptor is updated
      if (subscriber().take()) return true;
    }
    return false;
  });
  poller.reset();  // may still make the descriptor readable for that sample; take() then finds no sample
  EXPECT_FALSE(subscriber().take());
  EXPECT_FALSE(becomes_readable(0ms));
}

TEST_F(SubscriberWakeUp, OfAWaitOnASubscriberWithAFileDescriptorIsNeverLost) {
  open(0ns, PollHandle::create().value());
  Dispatcher poller(bell(), "test");
  poller.add(shared());
  ASSERT_TRUE(poller.start());
  exchange(rounds_of(5'000), [&] { return subscriber().wait(much_later) && subscriber().take(); });
}

}  // namespace
}  // namespace sft::core
