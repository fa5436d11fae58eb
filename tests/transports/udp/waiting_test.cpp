// Threads that wait for samples, and receive while they wait. The tests do not poll, so a test fails if a
// waiting thread is not woken.
#include <gtest/gtest.h>
#include <pthread.h>
#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <csignal>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "core/platform/doorbell.h"
#include "tests/transports/udp/endpoints.h"
#include "tests/transports/udp/transport_fixture.h"
#include "udp_transport/receive/receiving_role.h"

namespace sft::udp {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;
using test::eventually;
using test::fields;
using test::Image;
using test::loopback_address;
using test::make_image;
using test::Publisher;

/// A reader whose samples are awaited only by threads in receive().
class Waited final : private core::ArrivalListener {
 public:
  explicit Waited(core::Network& transport, core::EndpointId id = 1) {
    core::ReaderSpec spec{
        .id = id, .type = &test::type_support<Image>(), .depth = 1000, .listener = this, .doorbell = {}};
    spec.only_waited_for = true;
    port_ = transport.open_reader(spec).value();
    port_->accept({{.wanted = {fields<Image>("*")}}});
  }
  void listen_to(const Publisher& publisher) { EXPECT_TRUE(port_->connect({publisher.id(), 0})); }

  /// Waits for the next sample and returns it. Returns an empty handle after `at_most`. Counts how often the
  /// calling thread received.
  core::SampleHandle next(std::chrono::nanoseconds at_most = test::hang_timeout,
                          std::chrono::nanoseconds spin = 0ns) {
    const auto deadline = Clock::now() + at_most;
    for (;;) {
      const std::uint32_t seen = bell_.rings;
      core::SampleHandle sample = port_->take();
      if (sample || Clock::now() > deadline) return sample;
      listener_called_by_ = std::thread::id{};
      waits_ = true;
      const bool received = port_->receive({bell_, seen, deadline, Clock::now() + spin});
      waits_ = false;
      if (received) ++received_;
      if (received && listener_called_by_.load() == std::this_thread::get_id()) ++received_itself_;
      if (!received) bell_.wait(deadline, [&] { return bell_.rung(seen); });
    }
  }
  std::uint64_t next_sequence() {
    const core::SampleHandle sample = next();
    return sample ? sample->header().sequence : 0;
  }
  void share() { port_->share_reader(); }
  int received() const { return received_; }
  int received_itself() const { return received_itself_; }
  /// Returns true if the waiting thread is in receive(), or about to enter it.
  bool waits() const { return waits_; }
  /// Returns the number of samples that the thread received for this reader.
  int received_by(std::thread::id thread) const {
    const std::scoped_lock lock(mutex_);
    return static_cast<int>(std::ranges::count(called_by_, thread));
  }

 private:
  void arrived() noexcept override {
    listener_called_by_ = std::this_thread::get_id();
    {
      const std::scoped_lock lock(mutex_);
      called_by_.push_back(std::this_thread::get_id());
    }
    bell_.ring();
  }
  core::Doorbell bell_;
  std::atomic<std::thread::id> listener_called_by_{};
  std::atomic<int> received_{0}, received_itself_{0};
  std::atomic<bool> waits_{false};
  mutable std::mutex mutex_;
  std::vector<std::thread::id> called_by_;
  std::unique_ptr<core::NetworkReader> port_;  // destroyed first; after that no thread calls arrived()
};

class WaitingThread : public TransportTest {
 protected:
  void SetUp() override {
    TransportTest::SetUp();
    if (IsSkipped()) return;
    there = open();
    here = open();
    publisher = std::make_unique<Publisher>(*there);
    publisher->serve({{loopback_address(*here)}});
  }

  std::unique_ptr<core::Network> there, here;
  std::unique_ptr<Publisher> publisher;
};

/// A thread that is delayed before it waits may miss its turn. The test requires only that most samples are
/// not delayed in this way.
TEST_P(WaitingThread, GetsWhatComesWithoutAnotherThreadBetween) {
  constexpr std::uint64_t samples = 200;
  Waited reader(*here);
  reader.listen_to(*publisher);
  std::atomic<std::uint64_t> taken{0};
  std::jthread publishing([&] {
    for (std::uint64_t n = 1; n <= samples; ++n) {
      ASSERT_TRUE(eventually([&] { return taken == n - 1 && reader.waits(); }));
      publisher->publish(make_image(n % 5 == 0 ? 100'000 : 10));
    }
  });
  for (std::uint64_t n = 1; n <= samples; ++n, ++taken) ASSERT_EQ(reader.next_sequence(), n);
  EXPECT_GT(reader.received_itself(), static_cast<int>(samples / 2));
}

/// Returns the number of times that this thread has gone to sleep.
long times_asleep() {
  rusage usage{};
  ::getrusage(RUSAGE_THREAD, &usage);
  return usage.ru_nvcsw;
}

TEST_P(WaitingThread, CanKeepTheCoreBusyInstead) {
  Waited reader(*here);
  reader.listen_to(*publisher);
  std::atomic<std::uint64_t> taken{0};
  std::jthread publishing([&] {
    for (std::uint64_t n = 1; n <= 200; ++n) {
      publisher->publish(make_image(10));
      ASSERT_TRUE(eventually([&] { return taken >= n; }));
    }
  });
  for (std::uint64_t n = 1; n <= 200; ++n, ++taken) ASSERT_TRUE(reader.next(test::hang_timeout, 10ms)) << n;
  publishing.join();
  const long before = times_asleep();
  EXPECT_FALSE(reader.next(20ms, 20ms));
  EXPECT_EQ(times_asleep(), before);
  EXPECT_FALSE(reader.next(20ms));
  EXPECT_GT(times_asleep(), before) << "else that says nothing";
}

TEST_P(WaitingThread, ReceivesForOthersThatWait) {
  std::array<Waited, 3> readers{Waited{*here, 1}, Waited{*here, 2}, Waited{*here, 3}};
  std::array<std::unique_ptr<Publisher>, 3> publishers;
  std::array<std::atomic<std::uint64_t>, 3> taken{};
  std::vector<std::jthread> threads;
  for (std::size_t i = 0; i < readers.size(); ++i) {
    publishers[i] = std::make_unique<Publisher>(*there, 100 + i);
    publishers[i]->serve({{loopback_address(*here)}});
    readers[i].listen_to(*publishers[i]);
    threads.emplace_back([&, i] {
      while (readers[i].next_sequence() == taken[i] + 1 && ++taken[i] < 50) {
      }
    });
  }
  for (std::uint64_t n = 1; n <= 50; ++n) {
    for (std::size_t i = 0; i < readers.size(); ++i) {
      publishers[i]->publish(make_image(10));
      ASSERT_TRUE(eventually([&] { return taken[i] == n; })) << n << " of reader " << i;
    }
  }
  int for_others = 0;
  for (std::size_t i = 0; i < readers.size(); ++i) {
    for (std::size_t other = 0; other < readers.size(); ++other)
      for_others += other == i ? 0 : readers[i].received_by(threads[other].get_id());
  }
  EXPECT_GT(for_others, 50) << "of 100, while one receives and two wait";
}

TEST_P(WaitingThread, LeavesTheReceivingToOthersWhenItDoesNotComeBack) {
  Waited reader(*here, 1), other(*here, 2);
  reader.listen_to(*publisher);
  Publisher second(*there, 7);
  second.serve({{loopback_address(*here)}});
  other.listen_to(second);
  EXPECT_FALSE(reader.next(20ms));
  second.publish(make_image(10));
  ASSERT_TRUE(eventually([&] { return static_cast<bool>(other.next(0ns)); })) << "without anybody waiting";
}

TEST_P(WaitingThread, DoesNotCallTheListenersOfReadersThatAreNotOnlyWaitedFor) {
  Waited reader(*here);
  reader.listen_to(*publisher);
  std::jthread waiting([&] { EXPECT_EQ(reader.next_sequence(), 1U); });
  const auto waiting_thread = waiting.get_id();
  Publisher second(*there, 7);
  second.serve({{loopback_address(*here)}});
  class CalledBack final : public core::ArrivalListener {
   public:
    void arrived() noexcept override { by = std::this_thread::get_id(); }
    std::atomic<std::thread::id> by{};
  } called_back;
  auto polled = here->open_reader({.id = 2,
                                   .type = &test::type_support<Image>(),
                                   .depth = 1,
                                   .listener = &called_back,
                                   .doorbell = {}})
                    .value();
  polled->accept({{.wanted = {fields<Image>("*")}}});
  ASSERT_TRUE(polled->connect({second.id(), 0}));
  for (int i = 0; i < 20; ++i) {
    called_back.by = std::thread::id{};
    second.publish(make_image(10));
    ASSERT_TRUE(eventually([&] { return called_back.by.load() != std::thread::id{}; }));
    EXPECT_NE(called_back.by.load(), waiting_thread);
  }
  publisher->publish(make_image(10));
}

/// If no thread received for a moment, later samples on the reader's other path might overtake these samples.
TEST_P(WaitingThread, DoesNotReceiveForAReaderWithAnotherWay) {
  Waited reader(*here);
  reader.listen_to(*publisher);
  std::jthread waiting([&] { EXPECT_EQ(reader.next_sequence(), 1U); });
  reader.share();
  publisher->publish(make_image(10));
  waiting.join();
  EXPECT_EQ(reader.received_itself(), 0);
}

/// The reader's listener answers each sample by publishing the next one.
TEST_P(WaitingThread, IsNotNeededForLookingBeforeSleeping) {
  class CalledBack final : public core::ArrivalListener {
   public:
    void arrived() noexcept override {
      while (reader->take()) {
        if (++taken < 300) publisher->publish(make_image(10));
      }
    }
    core::NetworkReader* reader = nullptr;
    Publisher* publisher = nullptr;
    std::atomic<int> taken{0};
  } called_back;
  core::ReaderSpec spec{
      .id = 1, .type = &test::type_support<Image>(), .depth = 8, .listener = &called_back, .doorbell = {}};
  spec.spin = 1h;
  auto reader = here->open_reader(spec).value();
  called_back.reader = reader.get();
  called_back.publisher = publisher.get();
  reader->accept({{.wanted = {fields<Image>("*")}}});
  ASSERT_TRUE(reader->connect({publisher->id(), 0}));
  Publisher first(*there, 7);  // the listener uses the other publisher, perhaps before publish() returns here
  first.serve({{loopback_address(*here)}});
  ASSERT_TRUE(reader->connect({first.id(), 0}));
  first.publish(make_image(10));
  EXPECT_TRUE(eventually([&] { return called_back.taken == 300; }));
  reader.reset();
  here.reset();  // must return long before the hour of spinning is over
}

std::atomic<bool> held{false}, may_go{false};

/// The test delays a thread in the same way as a debugger or an application's signal handler can.
TEST_P(WaitingThread, LosesTheRoleWhileItIsHeldUp) {
  struct sigaction action {};
  action.sa_handler = [](int) {
    held = true;
    while (!may_go) std::this_thread::yield();
  };
  ASSERT_EQ(::sigaction(SIGUSR1, &action, nullptr), 0);
  held = may_go = false;
  Waited reader(*here, 1), other(*here, 2);
  reader.listen_to(*publisher);
  other.listen_to(*publisher);
  publisher->publish(make_image(10));
  EXPECT_EQ(reader.next_sequence(), 1U);
  std::jthread waiting([&] { EXPECT_EQ(reader.next_sequence(), 2U); });
  ASSERT_TRUE(eventually([&] { return reader.waits(); }));
  EXPECT_TRUE(other.next());
  EXPECT_FALSE(other.next(20ms)) << "by now it sleeps on the socket";
  ASSERT_EQ(::pthread_kill(waiting.native_handle(), SIGUSR1), 0);
  ASSERT_TRUE(eventually([] { return held.load(); }));
  publisher->publish(make_image(10));
  EXPECT_EQ(other.next_sequence(), 2U);
  may_go = true;
}

TEST_P(WaitingThread, IsSetFreeWhenItsTransportGoes) {
  Waited reader(*here);
  std::atomic<bool> over{false};
  std::jthread waiting([&] {
    while (!over) reader.next(1ms);
  });
  ASSERT_TRUE(eventually([&] { return reader.received() > 5; }));
  here.reset();
  over = true;
}

TEST_P(WaitingThread, GoesOnWhileReadersComeAndGo) {
  Waited reader(*here);
  reader.listen_to(*publisher);
  std::atomic<bool> over{false};
  std::jthread changing([&] {
    while (!over) {
      test::Subscriber passing(*here, {"*"}, 10, 9);
      passing.listen_to(publisher->id());
    }
  });
  for (std::uint64_t n = 1; n <= 200; ++n) {
    publisher->publish(make_image(n % 5 == 0 ? 20'000 : 10));
    ASSERT_EQ(reader.next_sequence(), n);
  }
  over = true;
}

INSTANTIATE_TEST_SUITE_P(Backends, WaitingThread, test::both_backends, test::backend_name);

}  // namespace
}  // namespace sft::udp
