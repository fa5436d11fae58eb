// The same program with the same quality of service gets the same samples over each transport. If a
// publisher waits for its subscribers, all reliable samples arrive. If the publisher does not wait, the
// samples that a subscriber misses are counted and logged.
#include <poll.h>

#include <mutex>
#include <numeric>
#include <std_msgs/msg/String.hpp>
#include <thread>
#include <vector>

#include "tests/system/fixture.h"

namespace sft::test {
namespace {

using std_msgs::msg::String;

constexpr std::uint32_t samples = 20'000;

class ReliablePairTest : public PubSubTest {
 protected:
  /// Takes samples until the sample with the number `last` has arrived, or until no more samples arrive.
  template <class S>
  static std::vector<std::uint64_t> take_all(S& subscriber, std::uint64_t last) {
    std::vector<std::uint64_t> numbers;
    while (subscriber.wait(hang_timeout)) {
      while (const auto sample = subscriber.take()) numbers.push_back(sample.info().sequence);
      if (!numbers.empty() && numbers.back() >= last) break;
    }
    return numbers;
  }
  /// Publishes a burst on a separate thread.
  template <class P>
  static std::jthread burst(P& publisher) {
    return std::jthread([&publisher] {
      String text;
      for (std::uint32_t i = 1; i <= samples; ++i) {
        text.data = "sample " + std::to_string(i);
        publisher.publish(text);
      }
    });
  }
  static std::vector<std::uint64_t> up_to(std::uint64_t last) {
    std::vector<std::uint64_t> all(last);
    std::iota(all.begin(), all.end(), 1);
    return all;
  }

  Node a = open("a");
  Node b = open("b");
};

TEST_P(ReliablePairTest, LosesNothingOfABurstOfAPublisherThatWaits) {
  warnings_expected = in_shared_memory();  // the depth exceeds the limit of shared memory
  auto publisher = a.publisher<String>("text", {.reliability = reliable, .max_blocking = 1s}).value();
  auto subscriber = b.subscriber<String>("text", {.reliability = reliable, .depth = 1000}).value();
  expect_served(publisher, 1);
  EXPECT_EQ(subscriber.status().writers.at(0).depth, in_shared_memory() ? 256U : 1000U);
  const std::jthread publishing = burst(publisher);
  EXPECT_EQ(take_all(subscriber, samples), up_to(samples));
  EXPECT_EQ(subscriber.status().lost, 0U);
}

TEST_P(ReliablePairTest, ASlowSubscriberAndAFastOneLoseNothing) {
  auto publisher = a.publisher<String>("text", {.reliability = reliable, .max_blocking = 1s}).value();
  auto quick = b.subscriber<String>("text", {.reliability = reliable, .depth = 4}).value();
  auto slow = b.subscriber<String>("text", {.reliability = reliable, .depth = 4}).value();
  expect_served(publisher, 2);
  const std::jthread publishing = burst(publisher);
  const std::jthread taking([&] { EXPECT_EQ(take_all(quick, samples), up_to(samples)); });
  std::vector<std::uint64_t> numbers;
  for (std::uint32_t i = 0; i < samples && slow.wait(hang_timeout); ++i) {
    const auto sample = slow.take();
    numbers.push_back(sample.info().sequence);
    if (i % 1000 == 0) poll(nullptr, 0, 5);
  }
  EXPECT_EQ(numbers, up_to(samples));
}

TEST_P(ReliablePairTest, WhatOneLosesThatIsNotWaitedForIsCountedAndLoggedAsAWarning) {
  std::mutex mutex;
  std::vector<std::string> warnings;
  NodeOptions options = node_options(GetParam(), "c");
  options.log = [&](LogLevel level, std::string_view text) {
    const std::scoped_lock lock(mutex);
    if (level >= LogLevel::warning) warnings.emplace_back(text);
  };
  Node c = Node::open(options).value();
  auto publisher = a.publisher<String>("text", {.reliability = reliable}).value();
  auto subscriber = c.subscriber<String>("text", {.reliability = reliable, .depth = 4}).value();
  expect_served(publisher, 1);
  publisher.publish(String{.data = "first"});
  ASSERT_EQ(take_all(subscriber, 1), up_to(1));
  burst(publisher).join();
  const std::vector<std::uint64_t> got = take_all(subscriber, samples + 1);
  ASSERT_FALSE(got.empty());
  EXPECT_EQ(got.back(), samples + 1);
  EXPECT_GT(subscriber.status().lost, 0U);
  EXPECT_EQ(got.size() + subscriber.status().lost, samples);
  EXPECT_TRUE(eventually([&] {
    const std::scoped_lock lock(mutex);
    return !warnings.empty();
  }));
  const std::scoped_lock lock(mutex);
  EXPECT_NE(warnings.at(0).find("although reliability was requested"), std::string::npos) << warnings[0];
}

INSTANTIATE_TEST_SUITE_P(Transports, ReliablePairTest,
                         ::testing::Values(Way::shm, Way::udp, Way::udp_sockets), way_name);

}  // namespace
}  // namespace sft::test
