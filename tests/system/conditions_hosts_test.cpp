// Subscribers with conditions on other hosts: many subscribers, subscribers whose cable is pulled, and
// subscribers whose cable loses, repeats and swaps frames.
#include <gtest/gtest.h>

#include <sft/sft.h>
#include <algorithm>
#include <array>
#include <atomic>
#include <memory>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <vector>

#include "tests/support/eventually.h"
#include "tests/support/isolated_host.h"
#include "tests/support/pace.h"
#include "tests/support/test_seed.h"
#include "tests/system/lossy_cable.h"
#include "tests/system/node_process.h"
#include "tests/system/rules.h"
#include "tools/hosts/network.h"

namespace sft::test {
namespace {

using sensor_msgs::msg::PointCloud2;
using F = PointCloud2::Field;
using namespace std::chrono_literals;

/// The number of samples. The stamp of a sample is its index among the published samples, counted from 0.
/// Its row_step is the number to which the conditions apply. The last sample, with index 2000, passes
/// `every 2nd` and `every 20th`.
constexpr std::size_t samples = 2001;

struct Published {
  std::atomic<bool> failed{false};
  std::atomic<std::size_t> served{0};
  std::atomic<std::size_t> in_groups{0};  ///< the number of readers that share multicast groups, counted
                                          ///< while no sample is due
  std::atomic<std::size_t> wanted{0};     ///< the number of samples to publish
  std::atomic<std::size_t> count{0};
  std::atomic<std::uint64_t> sent{0}, withheld{0}, dropped{0};  ///< totals of all readers
};

constexpr std::size_t readers_max = 16;

struct Taken {
  struct Reader {
    std::atomic<std::size_t> end{0};  ///< the index of the last sample that arrived, plus 1
    std::atomic<std::uint64_t> received{0}, lost{0}, withheld{0};
  };
  std::atomic<bool> failed{false};
  /// True if a sample arrived that should not have passed, was out of order, or did not have the requested
  /// part.
  std::atomic<bool> wrong{false};
  std::array<Reader, readers_max> readers{};
};

std::uint8_t byte_of(std::size_t place, std::size_t at) {
  return static_cast<std::uint8_t>(place + at * 31 + at / 256);
}
std::size_t bytes_of(std::size_t place) { return place % 7 == 0 ? 10'000 : place % 100; }

/// Returns a cloud with one row of points of one byte each.
PointCloud2 row(std::size_t place, std::uint32_t number) {
  PointCloud2 cloud{.height = 1, .point_step = 1, .row_step = number};
  cloud.header.stamp.sec = static_cast<std::int32_t>(place);
  cloud.width = static_cast<std::uint32_t>(bytes_of(place));
  for (std::size_t i = 0; i < cloud.width; ++i) cloud.data.push_back(byte_of(place, i));
  return cloud;
}

/// Publishes one of the numbers each millisecond.
void publish_numbers(Node& node, Published& published, Reliability reliability) {
  auto publisher = node.publisher<PointCloud2>("points", {.reliability = reliability}).value();
  const std::vector<std::uint32_t> numbers = random_numbers(samples, test_seed());
  for (Pace pace(1ms);; pace.await_turn()) {
    const std::size_t place = published.count;
    if (place < published.wanted) {
      publisher.publish(row(place, numbers[place]));
      published.count = place + 1;
    } else {
      std::size_t served = 0, in_groups = 0;
      std::uint64_t sent = 0, withheld = 0, dropped = 0;
      for (const PublisherStatus::Reader& reader : publisher.status().readers) {
        served += reader.served ? 1 : 0;
        in_groups += reader.multicast.starts_with("group ") ? 1 : 0;
        sent += reader.sent;
        withheld += reader.withheld;
        dropped += reader.dropped;
      }
      published.sent = sent;
      published.withheld = withheld;
      published.dropped = dropped;
      published.in_groups = in_groups;
      published.served = served;
    }
  }
}

/// A reader with conditions that requests a part of the data, and knows which samples must arrive.
class Choosy {
 public:
  Choosy(Node& node, const Rule& rule, Reliability reliability)
      : subscriber_(node.subscriber<PointCloud2, F::header | F::data>(
                            "points", {.reliability = reliability,
                                       .depth = 2 * samples,
                                       .selection = "header.stamp, data[::3] @ " + rule.conditions})
                        .value()),
        expected_(passing(rule, random_numbers(samples, test_seed()))) {}

  void take(Taken& taken, Taken::Reader& account) {
    while (const auto sample = subscriber_.take()) {
      const auto place = static_cast<std::size_t>(sample->header().stamp().sec());
      const auto found = std::lower_bound(expected_.begin(), expected_.end(), place);
      bool right = place >= account.end && found != expected_.end() && *found == place &&
                   sample->data().size() == (bytes_of(place) + 2) / 3;
      for (std::size_t i = 0; right && i < sample->data().size(); ++i)
        right = sample->data()[i] == byte_of(place, 3 * i);
      if (!right) taken.wrong = true;
      const SubscriberStatus status = subscriber_.status();
      account.received = status.received;
      account.lost = status.lost;
      account.withheld = status.withheld;
      account.end = place + 1;
    }
  }

 private:
  Subscriber<PointCloud2, F::header | F::data> subscriber_;
  const std::vector<std::size_t> expected_;
};

void take_by_rules(Node& node, Taken& taken, const std::vector<Rule>& rules, Reliability reliability) {
  std::vector<std::unique_ptr<Choosy>> readers;
  for (const Rule& rule : rules) readers.push_back(std::make_unique<Choosy>(node, rule, reliability));
  for (Pace pace(1ms);; pace.await_turn())
    for (std::size_t i = 0; i < readers.size(); ++i) readers[i]->take(taken, taken.readers[i]);
}

class PublisherProcess : public NodeProcessWith<Published> {
 public:
  PublisherProcess(const hosts::NetworkNamespace& host, const NodeOptions& options, Reliability reliability)
      : NodeProcessWith(host, options, [reliability](Node& node, Published& published) {
          publish_numbers(node, published, reliability);
        }) {}

  bool serves(std::size_t readers) const {
    return eventually([&] { return report().served == readers; });
  }
  /// Returns true once `end` samples have been published.
  bool publishes_up_to(std::size_t end) const {
    report().wanted = end;
    return eventually([&] { return report().count == end; });
  }
};

class SubscriberProcess : public NodeProcessWith<Taken> {
 public:
  SubscriberProcess(const hosts::NetworkNamespace& host, const NodeOptions& options, std::vector<Rule> rules,
                    Reliability reliability)
      : NodeProcessWith(host, options,
                        [&rules, reliability](Node& node, Taken& taken) {
                          take_by_rules(node, taken, rules, reliability);
                        }),
        rules_(std::move(rules)) {}

  /// Waits until each reader has received all samples with an index below `end` that pass its conditions.
  testing::AssertionResult has_all_before(std::size_t end) const {
    for (std::size_t i = 0; i < rules_.size(); ++i) {
      const std::vector<std::size_t> expected = expected_of(i, end);
      if (!eventually([&] { return reader(i).end == expected.back() + 1; }))
        return testing::AssertionFailure()
               << rules_[i].conditions << ": " << reader(i).end << " of " << expected.back() + 1;
    }
    return testing::AssertionSuccess();
  }
  /// Expects that every sample that passed has arrived, and that all other samples between the first and
  /// the last sample that passed count as withheld.
  void expect_all_accounted(std::size_t end) const {
    EXPECT_FALSE(report().wrong);
    for (std::size_t i = 0; i < rules_.size(); ++i) {
      const std::vector<std::size_t> expected = expected_of(i, end);
      EXPECT_EQ(reader(i).received, expected.size()) << rules_[i].conditions;
      EXPECT_EQ(reader(i).lost, 0U) << rules_[i].conditions;
      EXPECT_EQ(reader(i).withheld, expected.back() + 1 - expected.front() - expected.size())
          << rules_[i].conditions;
    }
  }
  /// Returns the number of samples that pass, summed over all readers.
  std::uint64_t passing_in_total() const {
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < rules_.size(); ++i) sum += expected_of(i, samples).size();
    return sum;
  }
  std::vector<std::size_t> expected_of(std::size_t reader, std::size_t end) const {
    std::vector<std::uint32_t> numbers = random_numbers(samples, test_seed());
    numbers.resize(end);
    return passing(rules_[reader], numbers);
  }
  const Taken::Reader& reader(std::size_t number) const { return report().readers[number]; }

 private:
  const std::vector<Rule> rules_;
};

class ConditionsOfOtherHosts : public testing::TestWithParam<bool> {
 protected:
  void SetUp() override {
    test_seed();  // child processes inherit the seed
    if (!isolation_refusal().empty()) GTEST_SKIP() << isolation_refusal();
  }
  static NodeOptions options() {
    NodeOptions options{.transport = TransportChoice::udp};
    options.udp.use_io_uring = GetParam();
    return options;
  }
};

INSTANTIATE_TEST_SUITE_P(By, ConditionsOfOtherHosts, testing::Bool(),
                         [](const auto& param) { return param.param ? "IoUring" : "Sockets"; });

TEST_P(ConditionsOfOtherHosts, SixtyFourReadersOnFourHostsGetJustWhatTheirOwnConditionsLetPass) {
  SCOPED_TRACE(how_to_repeat());
  const auto network = hosts::EmulatedNetwork::create(5);
  if (!network) GTEST_SKIP() << network.error().message;
  const std::vector<Rule> rules = different_rules(4 * readers_max);
  std::vector<std::unique_ptr<SubscriberProcess>> subscribers;
  const PublisherProcess publisher(network->host(0), options(), Reliability::reliable);
  for (std::size_t host = 1; host <= 4; ++host) {
    const auto first = rules.begin() + static_cast<std::ptrdiff_t>((host - 1) * readers_max);
    subscribers.push_back(std::make_unique<SubscriberProcess>(
        network->host(host), options(), std::vector(first, first + readers_max), Reliability::reliable));
  }
  ASSERT_TRUE(publisher.serves(rules.size()));
  ASSERT_TRUE(publisher.publishes_up_to(samples));
  std::uint64_t passing = 0;
  for (const auto& subscriber : subscribers) {
    ASSERT_TRUE(subscriber->has_all_before(samples));
    subscriber->expect_all_accounted(samples);
    passing += subscriber->passing_in_total();
  }
  const Published& published = publisher.report();
  EXPECT_TRUE(eventually([&] { return published.sent == passing; })) << published.sent << " of " << passing;
  EXPECT_EQ(published.withheld, rules.size() * samples - passing);
  EXPECT_EQ(published.dropped, 0U);
}

/// Two of the hosts share one set of conditions, and the other two hosts share another set.
TEST_P(ConditionsOfOtherHosts, HostsWithTheSameConditionsAreServedByOneGroupAndMissNothing) {
  SCOPED_TRACE(how_to_repeat());
  const auto network = hosts::EmulatedNetwork::create(5);
  if (!network) GTEST_SKIP() << network.error().message;
  const std::vector<Rule> rules{different_rules(6)[5], different_rules(8)[7]};
  const Reliability reliability = GetParam() ? Reliability::reliable : Reliability::best_effort;
  const PublisherProcess publisher(network->host(0), options(), reliability);
  std::vector<std::unique_ptr<SubscriberProcess>> subscribers;
  for (std::size_t host = 1; host <= 4; ++host)
    subscribers.push_back(std::make_unique<SubscriberProcess>(network->host(host), options(),
                                                              std::vector{rules[host % 2]}, reliability));
  ASSERT_TRUE(publisher.serves(4));
  ASSERT_TRUE(publisher.publishes_up_to(samples / 2));
  EXPECT_TRUE(eventually([&] { return publisher.report().in_groups == 4; }));
  ASSERT_TRUE(publisher.publishes_up_to(samples));
  for (const auto& subscriber : subscribers) {
    ASSERT_TRUE(subscriber->has_all_before(samples));
    subscriber->expect_all_accounted(samples);
  }
}

/// The cable is pulled for less than the lease of a node. Five hundred samples are published during that
/// time.
TEST_P(ConditionsOfOtherHosts, ACableThatIsPulledAndPutBackLosesNothingThatPassed) {
  SCOPED_TRACE(how_to_repeat());
  const auto network = hosts::EmulatedNetwork::create(2);
  if (!network) GTEST_SKIP() << network.error().message;
  const auto put = [&](const char* state) {
    const auto done = network->run_on_switch({"ip", "link", "set", hosts::EmulatedNetwork::port(1), state});
    ASSERT_TRUE(done) << done.error().message;
  };
  const std::vector<Rule> rules = different_rules(8);
  const PublisherProcess publisher(network->host(0), options(), Reliability::reliable);
  const SubscriberProcess subscriber(network->host(1), options(), rules, Reliability::reliable);
  ASSERT_TRUE(publisher.serves(rules.size()));
  ASSERT_TRUE(publisher.publishes_up_to(500));
  put("down");
  ASSERT_TRUE(publisher.publishes_up_to(1000));
  put("up");
  // A publisher keeps 4,096 samples for a host. With these eight readers, a published sample is kept about
  // three times, for different conditions. So about 1,300 published samples are kept.
  ASSERT_TRUE(publisher.publishes_up_to(1200));
  ASSERT_TRUE(subscriber.has_all_before(1200));
  ASSERT_TRUE(publisher.publishes_up_to(samples));
  ASSERT_TRUE(subscriber.has_all_before(samples));
  subscriber.expect_all_accounted(samples);
}

class ConditionsOnABadCable : public ConditionsOfOtherHosts {
 protected:
  void SetUp() override {
    ConditionsOfOtherHosts::SetUp();
    if (IsSkipped()) return;
    auto made = LossyCable::create({}, test_seed());
    if (!made) GTEST_SKIP() << made.error().message;
    cable = std::move(*made);
    ASSERT_TRUE(eventually([&] { return cable->notes().ready.load(); }));
  }
  /// Publishes all samples. The cable has no faults while the first and the last sample are sent.
  void publish_all(const PublisherProcess& publisher, const SubscriberProcess& subscriber) {
    ASSERT_TRUE(publisher.serves(rules.size()));
    ASSERT_TRUE(publisher.publishes_up_to(1));
    ASSERT_TRUE(subscriber.has_all_before(1));
    cable->become(true);
    ASSERT_TRUE(publisher.publishes_up_to(samples - 1));
    cable->become(false);
    ASSERT_TRUE(publisher.publishes_up_to(samples));
    ASSERT_TRUE(subscriber.has_all_before(samples));
    EXPECT_GT(cable->notes().lost, 10U);
  }

  /// Both rules let the first and the last sample pass.
  const std::vector<Rule> rules{different_rules(6)[5], different_rules(8)[7]};
  std::unique_ptr<LossyCable> cable;
};

INSTANTIATE_TEST_SUITE_P(By, ConditionsOnABadCable, testing::Bool(),
                         [](const auto& param) { return param.param ? "IoUring" : "Sockets"; });

TEST_P(ConditionsOnABadCable, AReliableReaderLosesNothingThatPassed) {
  SCOPED_TRACE(how_to_repeat());
  const PublisherProcess publisher(cable->host(0), options(), Reliability::reliable);
  const SubscriberProcess subscriber(cable->host(1), options(), rules, Reliability::reliable);
  publish_all(publisher, subscriber);
  subscriber.expect_all_accounted(samples);
}

TEST_P(ConditionsOnABadCable, AReaderTellsExactlyWhatWasLostFromWhatWasWithheld) {
  SCOPED_TRACE(how_to_repeat());
  const PublisherProcess publisher(cable->host(0), options(), Reliability::best_effort);
  const SubscriberProcess subscriber(cable->host(1), options(), rules, Reliability::best_effort);
  publish_all(publisher, subscriber);
  EXPECT_FALSE(subscriber.report().wrong);
  for (std::size_t i = 0; i < rules.size(); ++i) {
    const std::size_t passing = subscriber.expected_of(i, samples).size();
    const Taken::Reader& reader = subscriber.reader(i);
    EXPECT_EQ(reader.received + reader.lost, passing) << rules[i].conditions;
    EXPECT_GT(reader.lost, passing / 100) << rules[i].conditions;
    EXPECT_EQ(reader.withheld, samples - passing) << rules[i].conditions;
  }
}

}  // namespace
}  // namespace sft::test
