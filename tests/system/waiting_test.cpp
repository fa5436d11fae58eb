// Waiting for samples in an event loop, over each transport.
#include <sys/epoll.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <thread>
#include <vector>

#include "core/platform/file_descriptor.h"
#include "tests/system/fixture.h"

namespace sft::test {
namespace {

/// An event loop of a program.
class Loop {
 public:
  explicit Loop(int fd, std::uint32_t events = EPOLLIN) {
    epoll_event event{.events = events, .data = {}};
    EXPECT_EQ(::epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, fd, &event), 0);
  }
  /// Returns true if the descriptor becomes ready in time. The kernel may interrupt the wait even without a
  /// signal, when it removes the io_uring rings of an earlier test.
  bool wakes(std::chrono::milliseconds within) {
    epoll_event event{};
    int ready = 0;
    do {
      ready = ::epoll_wait(epoll_.get(), &event, 1, static_cast<int>(within.count()));
    } while (ready < 0 && errno == EINTR);
    return ready == 1;
  }

 private:
  core::FileDescriptor epoll_{::epoll_create1(EPOLL_CLOEXEC)};
};

class WaitingTest : public PubSubTest {
 protected:
  /// Takes a sample and returns its sequence, or 0 if there is none.
  template <class S>
  static std::uint64_t taken(S& subscriber) {
    const auto sample = subscriber.take();
    return sample ? sample.info().sequence : 0;
  }
};

TEST_P(WaitingTest, AFileDescriptorIsReadableWhileThereIsASample) {
  Node a = open("a");
  Node b = open("b");
  auto pub = a.publisher<PointCloud2>("points").value();
  auto sub = b.subscriber<PointCloud2, F::height>("points", {.pollable = true}).value();
  Loop loop(sub.file_descriptor());
  expect_served(pub, 1);
  EXPECT_FALSE(loop.wakes(0ms));
  for (std::uint32_t i = 1; i <= 2; ++i) pub.publish(cloud(i));
  ASSERT_TRUE(loop.wakes(5s));
  EXPECT_EQ(taken(sub), 1U);
  EXPECT_TRUE(loop.wakes(5s)) << "there is another";
  EXPECT_EQ(taken(sub), 2U);
  EXPECT_TRUE(eventually([&] { return !sub.take() && !loop.wakes(0ms); }));
}

TEST_P(WaitingTest, AnEdgeTriggeredLoopThatTakesAllEachTimeMissesNothing) {
  constexpr std::uint64_t samples = 2000;
  Node a = open("a");
  Node b = open("b");
  auto pub = a.publisher<PointCloud2>("points").value();
  auto sub = b.subscriber<PointCloud2, F::height>("points", {.depth = 64, .pollable = true}).value();
  Loop loop(sub.file_descriptor(), EPOLLIN | EPOLLET);
  expect_served(pub, 1);
  std::atomic<std::uint64_t> taken{0};
  std::thread publishing([&] {
    for (std::uint32_t i = 1; i <= samples; ++i) {
      pub.publish(cloud(i, 10));
      while (taken + 32 < i) std::this_thread::yield();
    }
  });
  while (taken < samples && loop.wakes(10s)) {
    while (sub.take()) ++taken;
  }
  EXPECT_EQ(taken, samples);
  taken = samples;
  publishing.join();
}

TEST_P(WaitingTest, WaitWorksOnASubscriberWithAFileDescriptorToo) {
  Node a = open("a");
  Node b = open("b");
  auto pub = a.publisher<PointCloud2>("points").value();
  auto sub = b.subscriber<PointCloud2, F::height>("points", {.pollable = true}).value();
  expect_served(pub, 1);
  EXPECT_FALSE(sub.wait(5ms));
  pub.publish(cloud(7));
  ASSERT_TRUE(sub.wait(hang_timeout));
  EXPECT_EQ(taken(sub), 1U);
}

/// The node that the signal handler interrupts.
std::atomic<Node*> node_of_handler{nullptr};

TEST_P(WaitingTest, ASignalHandlerEndsTheWaitsOfEachSubscriberOfANode) {
  Node a = open("a");
  Node b = open("b");
  auto publisher = a.publisher<PointCloud2>("points").value();
  auto served = b.subscriber<PointCloud2, F::height>("points").value();
  auto another = b.subscriber<PointCloud2, F::height>("points").value();
  auto pollable = b.subscriber<PointCloud2, F::height>("points", {.pollable = true}).value();
  Loop loop(pollable.file_descriptor());
  expect_served(publisher, 3);
  std::vector<std::jthread> waits;
  waits.emplace_back([&] { EXPECT_FALSE(served.wait(1h)); });
  waits.emplace_back([&] { EXPECT_FALSE(another.wait(1h)); });
  waits.emplace_back([&] { EXPECT_FALSE(pollable.wait(1h)); });
  waits.emplace_back([&] { EXPECT_FALSE(b.find_type("no such topic", 1h)); });

  node_of_handler = &b;
  struct sigaction interrupts {
  }, before{};
  interrupts.sa_handler = [](int) { node_of_handler.load()->interrupt(); };
  ASSERT_EQ(::sigaction(SIGUSR1, &interrupts, &before), 0);
  EXPECT_FALSE(b.is_interrupted());
  ::raise(SIGUSR1);
  waits.clear();
  EXPECT_TRUE(b.is_interrupted());
  EXPECT_FALSE(a.is_interrupted());
  EXPECT_TRUE(loop.wakes(5s));
  ::sigaction(SIGUSR1, &before, nullptr);

  publisher.publish(cloud(7));
  EXPECT_TRUE(eventually([&] { return served.wait(1h); })) << "samples still come";
  EXPECT_EQ(taken(served), 1U);
}

TEST_P(WaitingTest, OnlyWhoAsksForAFileDescriptorHasOneAndNotBesideACallback) {
  Node node = open("a");
  EXPECT_EQ((node.subscriber<PointCloud2, F::height>("points").value().file_descriptor()), -1);
  const auto both = node.subscriber<PointCloud2, F::height>("points", [](const auto&) {}, {.pollable = true});
  ASSERT_FALSE(both);
  EXPECT_EQ(both.error().code, Errc::invalid_argument);
  EXPECT_NE(both.error().message.find("pollable"), std::string::npos) << both.error().message;
}

INSTANTIATE_TEST_SUITE_P(Ways, WaitingTest, testing::Values(Way::shm, Way::udp, Way::udp_sockets), way_name);

}  // namespace
}  // namespace sft::test
