// Many subscribers of one publisher, each with conditions, and subscribers with conditions that join and
// leave, over every transport.
#include <gmock/gmock.h>
#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <fstream>
#include <thread>
#include <utility>
#include <vector>

#include "bench/common/counters.h"
#include "tests/support/isolated_host.h"
#include "tests/support/pace.h"
#include "tests/support/test_seed.h"
#include "tests/system/fixture.h"
#include "tests/system/rules.h"

namespace sft::test {
namespace {

/// The indices ("places") of samples among the published ones, counted from 0. A sample's stamp is its
/// index.
using Places = std::vector<std::size_t>;

constexpr std::size_t samples = 200;
const SubscriberOptions all_kept{.reliability = Reliability::reliable, .depth = 256};

class ConditionsTest : public PubSubTest {
 protected:
  DynamicType type() { return b.find_type("points", hang_timeout).value(); }
  static std::string text(const Rule& rule) { return "header.stamp @ " + rule.conditions; }
  /// Returns the sample with that index. The conditions apply to its `number`.
  static PointCloud2 sample(std::size_t place, std::uint32_t number) {
    PointCloud2 cloud;
    cloud.header.stamp.sec = static_cast<std::int32_t>(place);
    cloud.row_step = number;
    return cloud;
  }
  void publish(const std::vector<std::uint32_t>& numbers) {
    for (std::size_t i = 0; i < numbers.size(); ++i)
      ASSERT_EQ(pub.publish(sample(i, numbers[i])), PublishStatus::ok);
  }
  static std::size_t place_of(const DynamicSample& sample) {
    return static_cast<std::size_t>(sample.view()["header"]["stamp"]["sec"].as<std::int32_t>().value());
  }
  /// Takes all samples up to the sample with the index `last`, which must arrive. Returns the indices of
  /// the samples.
  static Places until(DynamicSubscriber& sub, std::size_t last) {
    Places places;
    while (places.empty() || places.back() != last) {
      if (!sub.wait(10s)) {
        ADD_FAILURE() << "sample " << last << " did not come";
        break;
      }
      while (const DynamicSample sample = sub.take()) places.push_back(place_of(sample));
    }
    return places;
  }
  /// Returns the publisher's counts for the reader with that selection.
  PublisherStatus::Reader account_of(const std::string& selection) {
    const Selection wanted = points.closed(points.parse_selection(selection).value());
    for (PublisherStatus::Reader& reader : pub.status().readers)
      if (reader.selection == wanted) return reader;
    ADD_FAILURE() << "nobody asks for " << selection;
    return {};
  }
  /// Opens a subscriber for each rule and publishes to all of them. Compares the samples that each
  /// subscriber gets, and the counts of both sides, with the expected ones according to the rules.
  void expect_that_each_gets_its_own(std::size_t readers) {
    SCOPED_TRACE(how_to_repeat());
    const std::vector<Rule> rules = different_rules(readers);
    const DynamicType type = this->type();
    std::vector<DynamicSubscriber> subs;
    for (const Rule& rule : rules) subs.push_back(b.subscriber("points", type, text(rule), all_kept).value());
    expect_served(pub, readers);
    const std::vector<std::uint32_t> numbers = random_numbers(samples, test_seed());
    publish(numbers);
    for (std::size_t i = 0; i < readers; ++i) {
      SCOPED_TRACE(rules[i].conditions);
      const Places expected = passing(rules[i], numbers);
      ASSERT_EQ(until(subs[i], expected.back()), expected);
      EXPECT_EQ(subs[i].status().lost, 0U);
      EXPECT_EQ(subs[i].status().withheld, expected.back() + 1 - expected.front() - expected.size());
      const PublisherStatus::Reader account = account_of(text(rules[i]));
      EXPECT_EQ(account.sent, expected.size()) << "nothing more is under way";
      EXPECT_EQ(account.withheld, samples - expected.size());
      EXPECT_EQ(account.dropped, 0U);
    }
  }

  const TypeSupport& points = type_support<PointCloud2>();
  Node a = open("a");
  Node b = open("b");
  Publisher<PointCloud2> pub =
      a.publisher<PointCloud2>("points", {.reliability = Reliability::reliable}).value();
};

TEST_P(ConditionsTest, EachOfSixtyFourReadersGetsJustWhatItsOwnConditionsLetPass) {
  expect_that_each_gets_its_own(64);
}

/// A sample in shared memory contains the ids of at most 64 gates. A reader of a further gate cannot
/// distinguish withheld samples from lost ones, but gets the right samples.
TEST_P(ConditionsTest, MoreReadersThanASampleCanNameGatesForGetTheirsAllTheSame) {
  expect_that_each_gets_its_own(80);
}

/// The other reader gets every sample. This shows that without its condition the first reader would have
/// got these samples, too. The other reader is on a separate node, because a waiting thread receives
/// datagrams for all subscribers of its node.
TEST_P(ConditionsTest, AReaderBehindAClosedGateIsNotWokenByAThousandSamples) {
  const DynamicType type = this->type();
  auto quiet = b.subscriber("points", type, "header.stamp @ row_step > 1000", all_kept).value();
  Node c = open("c");
  auto other =
      c.subscriber("points", c.find_type("points", hang_timeout).value(), "header.stamp", all_kept).value();
  expect_served(pub, 2);
  publish({1001});
  EXPECT_EQ(until(quiet, 0), Places{0});
  EXPECT_EQ(until(other, 0), Places{0});
  std::atomic<pid_t> waiting{0};
  std::atomic<bool> came{false};
  std::jthread waiter([&] {
    waiting = gettid();
    came = quiet.wait(60s);
  });
  ASSERT_TRUE(eventually([&] { return waiting != 0; }));
  const auto sleeps = [&] {
    std::string line;
    std::getline(std::ifstream("/proc/self/task/" + std::to_string(waiting) + "/stat"), line);
    return line.substr(line.rfind(')') + 1).starts_with(" S");
  };
  ASSERT_TRUE(eventually(sleeps));
  const bench::ProcessCounter counter(getpid());
  const auto wake_ups = [&] {
    for (const bench::ThreadCounts& thread : counter.read())
      if (thread.thread == waiting) return thread.counts.wake_ups;
    return std::int64_t{-1};
  };
  std::int64_t before = -1;
  const auto changes = [&] { return std::exchange(before, wake_ups()) != before; };
  // The agent may still have work to do for the last change of the negotiation.
  ASSERT_TRUE(eventually([&] { return !changes() && !eventually(changes, 300ms); }));
  ASSERT_GE(before, 0);
  for (std::size_t i = 1; i <= 1000; ++i) {
    ASSERT_EQ(pub.publish(sample(i, 1000)), PublishStatus::ok);
    ASSERT_EQ(until(other, i), Places{i});
  }
  EXPECT_EQ(wake_ups(), before);
  EXPECT_FALSE(came);
  ASSERT_EQ(pub.publish(sample(1001, 1001)), PublishStatus::ok);
  waiter.join();
  EXPECT_TRUE(came);
  EXPECT_EQ(until(quiet, 1001), Places{1001});
  EXPECT_EQ(quiet.status().withheld, 1000U);
  EXPECT_EQ(quiet.status().lost, 0U);
}

/// Returns the memory that the program has allocated at present, in bytes; 0 if the allocator does not
/// report this.
std::size_t memory_in_use() { return mallinfo2().uordblks; }

/// Each of these readers has its own conditions, so the publisher makes a gate for each reader, and removes
/// most of the gates later.
TEST_P(ConditionsTest, AReaderThatComesAndGoesTwoHundredTimesCostsTheOtherReadersNothing) {
  SCOPED_TRACE(how_to_repeat());
  constexpr std::size_t rounds = 200, warm = 100;
  // A reader that joins and leaves costs both nodes about 1000 bytes, whatever its selection is. A queue or a
  // sample that is never returned costs more.
  constexpr std::size_t growth_max = 4000 * (rounds - warm);
  const std::vector<Rule> rules = different_rules(1);
  const DynamicType type = this->type();
  auto steady = b.subscriber("points", type, text(rules[0]), all_kept).value();
  expect_served(pub, 1);
  const std::vector<std::uint32_t> numbers = random_numbers(samples * 4, test_seed());
  const Places expected = passing(rules[0], numbers);
  Places taken;
  std::size_t published = 0, memory = 0;
  const auto publish_next = [&] {
    ASSERT_EQ(pub.publish(sample(published, numbers[published])), PublishStatus::ok);
    ++published;
  };
  for (std::size_t round = 0; round < rounds; ++round) {
    const std::string own = "header.stamp @ changed(row_step) " + std::to_string(1000 + round);
    {
      auto guest = b.subscriber("points", type, own, all_kept).value();
      expect_served(pub, 2);
      for (int i = 0; i < 4; ++i) publish_next();
      EXPECT_EQ(until(guest, published - 4), Places{published - 4}) << "the first one, and nothing else";
    }
    expect_served(pub, 1);
    while (const DynamicSample sample = steady.take()) taken.push_back(place_of(sample));
    if (round == warm) memory = memory_in_use();
  }
  const Places rest =
      taken.empty() || taken.back() != expected.back() ? until(steady, expected.back()) : Places{};
  taken.insert(taken.end(), rest.begin(), rest.end());
  EXPECT_EQ(taken, expected);
  EXPECT_EQ(steady.status().lost, 0U);
  EXPECT_EQ(steady.status().withheld, expected.back() + 1 - expected.front() - expected.size());
  EXPECT_LT(memory_in_use(), memory + growth_max);
}

INSTANTIATE_TEST_SUITE_P(Ways, ConditionsTest, ::testing::Values(Way::shm, Way::udp, Way::udp_sockets),
                         way_name);

}  // namespace
}  // namespace sft::test
