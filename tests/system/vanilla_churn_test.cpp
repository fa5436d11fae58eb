// Unmodified DDS nodes are started, ended, killed and stopped, with other types and QoS each time. The node
// of SFT communicates with all nodes that are present, and does not use more and more resources.
#include <gmock/gmock.h>

#include <array>
#include <atomic>
#include <memory>

#include "tests/support/pace.h"
#include "tests/support/test_seed.h"
#include "tests/system/holdings.h"
#include "tests/system/node_process.h"
#include "tests/system/vanilla_fixture.h"

namespace sft::test {
namespace {

/// Cyclone DDS keeps free lists, which fill up in the first rounds, and forgets departed nodes some time
/// later.
constexpr Holdings growth_max{.bytes = 2 << 20, .descriptors = 4, .threads = 2};

class VanillaChurn : public VanillaTest {
 protected:
  VanillaChurn() { warnings_expected = true; }  // an endpoint of another type is named

  bool has_grown_since(const Holdings& before) const {
    const Holdings more = Holdings::of_this_process() - before;
    return more.bytes > growth_max.bytes || more.descriptors > growth_max.descriptors ||
           more.threads > growth_max.threads;
  }
  void expect_no_growth_since(const Holdings& before) const {
    EXPECT_TRUE(eventually([&] { return !has_grown_since(before); }))
        << (Holdings::of_this_process() - before).bytes << " bytes, "
        << (Holdings::of_this_process() - before).descriptors << " descriptors and "
        << (Holdings::of_this_process() - before).threads << " threads more";
  }
  /// Publishes until the echo brings a new cloud.
  void expect_echo() {
    EXPECT_TRUE(eventually([&] {
      pub_.publish(cloud(++number_));
      if (!sub_.wait(100ms)) return false;
      const auto sample = sub_.take();
      return sample->height() > number_ - 10;
    }));
  }

  Node node_ = open(Way::udp);
  /// Retains a sample, so that latched readers match, too.
  Publisher<PointCloud2> pub_ =
      node_.publisher<PointCloud2>("points", {.durability = transient_local}).value();
  Subscriber<PointCloud2> sub_ = node_.subscriber<PointCloud2>("echoed").value();
  std::uint32_t number_ = 100;
};

TEST_F(VanillaChurn, NodesThatJoinAndLeaveLeaveNothingBehind) {
  auto heard = node_.subscriber<PointCloud2>("points", {.depth = 10}).value();
  pub_.publish(cloud(1));
  VanillaJoins nodes(network_.host(1), "rt/points");
  constexpr std::uint64_t at_first = 12;
  const std::uint64_t rounds = test_rounds(30);
  EXPECT_EQ(nodes.join(2, at_first), at_first);
  ASSERT_TRUE(serves(pub_, 0));
  const Holdings before = Holdings::of_this_process();
  EXPECT_EQ(nodes.join(3, rounds), rounds);
  EXPECT_TRUE(serves(pub_, 0) && hears(heard, 1)) << "only its own publisher is left";
  expect_no_growth_since(before);
  VanillaEcho echo(network_.host(1), {});
  expect_echo();
}

TEST_F(VanillaChurn, AnyOrderOfKillsStopsAndRestartsLeavesAWorkingNode) {
  Random random(test_seed());
  constexpr std::size_t places = 3;
  std::array<std::unique_ptr<VanillaEcho>, places> echoes;
  const auto act = [&] {
    auto& echo = echoes[random() % places];
    if (echo == nullptr) {
      const bool is_reliable = random() % 2 == 0;
      echo = std::make_unique<VanillaEcho>(
          network_.host(random() % 2),
          VanillaEcho::How{.reliability = is_reliable ? "reliable" : "best_effort",
                           .durability = is_reliable && random() % 2 == 0 ? "latched" : "volatile",
                           .depth = 1 + static_cast<int>(random() % 10)});
    } else if (const auto what = random() % 3; what == 0) {
      echo->kill_now();
      echo.reset();
    } else {
      what == 1 ? echo->hold_up() : echo->let_go();
    }
    pub_.publish(cloud(++number_));
    while (sub_.take()) continue;
  };
  const auto all_gone = [&] {
    for (auto& echo : echoes) echo.reset();
    return serves(pub_, 0) && hears(sub_, 0);
  };
  Pace pace(std::chrono::milliseconds(30));
  for (int i = 0; i < 20; ++i, pace.await_turn()) act();
  ASSERT_TRUE(all_gone());
  const Holdings before = Holdings::of_this_process();
  for (int i = 0; i < 60; ++i, pace.await_turn()) act();
  ASSERT_TRUE(all_gone()) << how_to_repeat();
  expect_no_growth_since(before);
  VanillaEcho echo(network_.host(1), {});
  expect_echo();
}

/// A node with a publisher and a subscriber for each pair of other nodes.
class VanillaManyTest : public VanillaTest {
 protected:
  struct Pair {
    Publisher<PointCloud2> in;
    Subscriber<PointCloud2> out;
  };
  void add_pairs(std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      const std::string number = std::to_string(i);
      pairs_.push_back({node_.publisher<PointCloud2>("in_" + number).value(),
                        node_.subscriber<PointCloud2>("out_" + number, {.reliability = reliable}).value()});
    }
  }
  /// Publishes one cloud of each pair, and waits until each of them comes back.
  void expect_that_each_comes_back() {
    for (Pair& pair : pairs_) ASSERT_TRUE(serves(pair.in, 1) && hears(pair.out, 1));
    for (std::uint32_t i = 0; i < pairs_.size(); ++i) pairs_[i].in.publish(cloud(i));
    for (std::uint32_t i = 0; i < pairs_.size(); ++i) {
      ASSERT_TRUE(pairs_[i].out.wait(hang_timeout)) << i;
      const auto sample = pairs_[i].out.take();
      EXPECT_EQ(sample->height(), i);
    }
  }

  Node node_ = open(Way::udp);
  std::vector<Pair> pairs_;
};

TEST_F(VanillaManyTest, TwoHundredEndpointsOfAProcessAreServedAndHeard) {
  constexpr std::size_t pairs = 100;
  add_pairs(pairs);
  VanillaMany others(network_.host(1), 1, pairs);
  ASSERT_TRUE(others.is_ready());
  expect_that_each_comes_back();
}

TEST_F(VanillaManyTest, ThirtyNodesWithAHundredAndFiftyTopicsCostAStreamNoSample) {
  constexpr std::size_t nodes = 30, pairs_of_node = 5;
  auto pub = node_.publisher<PointCloud2>("points", {.reliability = reliable}).value();
  auto sub = node_.subscriber<PointCloud2>("points", {.reliability = reliable, .depth = 10'000}).value();
  VanillaEcho echo(network_.host(1), {});
  auto echoed = node_.subscriber<PointCloud2>("echoed", {.reliability = reliable, .depth = 10'000}).value();
  ASSERT_TRUE(serves(pub, 1) && hears(sub, 1) && hears(echoed, 1) && echo.matches(2));
  std::uint32_t published = 0;
  std::optional<Ticker> stream(std::in_place, 20ms, [&](std::uint32_t number) {
    pub.publish(cloud(number, 10'000));
    published = number;
  });
  add_pairs(nodes * pairs_of_node);
  VanillaMany others(network_.host(1), nodes, pairs_of_node);
  ASSERT_TRUE(others.is_ready());
  expect_that_each_comes_back();
  stream.reset();
  for (std::uint32_t i = 1; i <= published; ++i) {
    ASSERT_TRUE(sub.wait(hang_timeout));
    const auto sample = sub.take();
    ASSERT_EQ(sample->height(), i);
  }
  for (std::uint32_t last = 0; last < published;) {
    ASSERT_TRUE(echoed.wait(hang_timeout));
    const auto sample = echoed.take();
    last = sample->height();
  }
}

struct Echoes {
  std::atomic<std::uint64_t> count{0};
  std::atomic<bool> failed{false};
};

class VanillaPairChurn : public VanillaTest {
 protected:
  using NodeProcess = NodeProcessWith<Echoes>;

  std::unique_ptr<NodeProcess> make_node() const {
    return std::make_unique<NodeProcess>(
        network_.host(0), node_options(Way::udp, "camera"), [](Node& node, Echoes& echoes) {
          auto sub = node.subscriber<PointCloud2>("echoed", [&](const auto&) { ++echoes.count; }).value();
          auto pub = node.publisher<PointCloud2>("points").value();
          for (Pace pace(20ms);; pace.await_turn()) pub.publish({.height = 1});
        });
  }
  std::unique_ptr<VanillaEcho> make_echo() const {
    return std::make_unique<VanillaEcho>(network_.host(1), VanillaEcho::How{});
  }
  /// Starts the process if there is none, or else kills it, stops it or lets it go on.
  template <class Process, class Make>
  static void change(std::unique_ptr<Process>& process, std::uint64_t how, Make make) {
    if (process == nullptr) {
      process = make();
    } else if (how == 0) {
      process.reset();
    } else {
      how == 1 ? process->hold_up() : process->let_go();
    }
  }
};

TEST_F(VanillaPairChurn, AnyOrderOfKillsAndStopsOfBothSidesEndsInAWorkingPair) {
  Random random(test_seed());
  std::unique_ptr<NodeProcess> node = make_node();
  std::unique_ptr<VanillaEcho> echo = make_echo();
  Pace pace(100ms);
  for (int i = 0; i < 8; ++i) {
    change(node, random() % 3, [&] { return make_node(); });
    pace.await_turn();
    change(echo, random() % 3, [&] { return make_echo(); });
    pace.await_turn();
  }
  if (node == nullptr) node = make_node();
  if (echo == nullptr) echo = make_echo();
  node->let_go();
  echo->let_go();
  const std::uint64_t before = node->report().count;
  EXPECT_TRUE(eventually([&] { return node->report().count > before + 10; })) << how_to_repeat();
  EXPECT_FALSE(node->report().failed);
}

}  // namespace
}  // namespace sft::test
