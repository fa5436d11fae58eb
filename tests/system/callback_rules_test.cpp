// The actions that a program may take in its callbacks. Each row of the table in docs/guide.md is tried in
// each kind of callback, and on a thread for which the callback waits.
#include <array>
#include <atomic>
#include <barrier>
#include <condition_variable>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "tests/system/fixture.h"

namespace sft::test {
namespace {

/// A node `here` with all kinds of callbacks, a node `there` whose endpoints trigger them, and a third node.
struct Scene {
  std::optional<Node> here, there, other_node;
  std::optional<Publisher<PointCloud2>> calling_publisher, other_publisher, far_publisher;
  std::optional<Subscriber<PointCloud2>> calling_subscriber, other_subscriber, far_subscriber;
};

using Act = std::function<void(Scene&)>;

const std::map<std::string, Act> acts{
    {"open nodes, publishers and subscribers",
     [](Scene& s) {
       EXPECT_TRUE(Node::open({.name = "third"}));
       EXPECT_TRUE(s.here->publisher<PointCloud2>("new"));
       EXPECT_TRUE(s.here->subscriber<PointCloud2>("new", [](const auto&) {}));
     }},
    {"`find_type()`, `topics()`, `domain()`, `ask_accounts()`",
     [](Scene& s) {
       EXPECT_TRUE(s.here->find_type("points", hang_timeout));
       EXPECT_FALSE(s.here->find_type("nobody has this", 1ms));
       EXPECT_FALSE(s.here->topics().empty());
       EXPECT_FALSE(s.here->domain().publishers.empty());
       EXPECT_TRUE(s.here->ask_accounts("points"));
     }},
    {"`status()`, `snapshot()`, `requirements()`",
     [](Scene& s) {
       static_cast<void>(s.here->status());
       EXPECT_FALSE(s.here->snapshot().publishers.empty());
       static_cast<void>(s.calling_publisher->status());
       static_cast<void>(s.calling_subscriber->status());
       static_cast<void>(s.calling_subscriber->requirements());
     }},
    {"`publish()`, `loan()`, `take()`",
     [](Scene& s) {
       EXPECT_EQ(s.other_publisher->publish({.height = 1}), PublishStatus::ok);
       EXPECT_TRUE(s.other_publisher->loan({}));
       static_cast<void>(s.other_subscriber->take());
       s.other_publisher->assert_liveliness();
       EXPECT_TRUE(s.other_publisher->wait_for_subscribers(1, hang_timeout));
     }},
    {"`wait()`",
     [](Scene& s) {
       EXPECT_EQ(s.other_publisher->publish({.height = 1}), PublishStatus::ok);
       EXPECT_TRUE(s.other_subscriber->wait(hang_timeout));
       EXPECT_TRUE(s.other_subscriber->take());
     }},
    {"`set_max_rate_hz()`, `set_selection()`",
     [](Scene& s) {
       EXPECT_TRUE(s.calling_subscriber->set_max_rate_hz(1000));
       EXPECT_TRUE(s.other_subscriber->set_max_rate_hz(1000));
     }},
    {"`interrupt()`",
     [](Scene& s) {
       s.other_node->interrupt();
       EXPECT_TRUE(s.other_node->is_interrupted());
     }},
    {"destroy other publishers, subscribers and nodes",
     [](Scene& s) {
       s.other_publisher.reset();
       s.other_subscriber.reset();
       s.other_node.reset();
     }},
    {"destroy what calls back",
     [](Scene& s) {
       s.calling_publisher.reset();
       s.calling_subscriber.reset();
       s.other_publisher.reset();
       s.other_subscriber.reset();
       s.here.reset();
     }},
};

enum class Kind { sample, event, readers, log };

/// A row of the table in docs/guide.md.
struct Rule {
  std::string act;
  std::string for_samples, for_others, by_a_thread;
};

Rule parse_rule(const std::string& row) {
  std::vector<std::string> cells;
  for (std::size_t at = 2, end = 0; (end = row.find(" |", at)) != std::string::npos; at = end + 3)
    cells.push_back(row.substr(at, end - at));
  cells.resize(4);
  return {cells[0], cells[1], cells[2], cells[3]};
}

std::vector<Rule> rules_of_the_guide() {
  std::ifstream guide(GUIDE);
  std::string line;
  while (std::getline(guide, line) && !line.starts_with("| | in a callback for samples |")) continue;
  std::getline(guide, line);
  std::vector<Rule> rules;
  while (std::getline(guide, line) && line.starts_with("| ")) rules.push_back(parse_rule(line));
  return rules;
}

TEST(CallbackRules, AreThoseOfTheGuide) {
  std::size_t known = 0;
  for (const Rule& rule : rules_of_the_guide()) {
    EXPECT_TRUE(acts.contains(rule.act)) << rule.act;
    EXPECT_EQ(rule.for_others, "yes") << rule.act;
    EXPECT_TRUE(rule.for_samples == "yes" || rule.for_samples == "returns at once") << rule.act;
    EXPECT_TRUE(rule.by_a_thread == "yes" || rule.by_a_thread.starts_with("no: ")) << rule.act;
    ++known;
  }
  EXPECT_EQ(known, acts.size());
}

/// Runs an act in the first callback of a kind after arm(). A node that is closed in its own callback may
/// call back for a while, even after the end of the test.
class ActInCallback {
 public:
  void arm(Kind kind, std::function<void()> act) {
    const std::lock_guard lock(mutex_);
    armed_ = kind;
    act_ = std::move(act);
  }
  bool is_done() {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, hang_timeout, [&] { return done_; });
  }
  void called(Kind kind) {
    {
      const std::lock_guard lock(mutex_);
      if (armed_ != kind) return;
      armed_.reset();
    }
    act_();
    const std::lock_guard lock(mutex_);
    done_ = true;
    changed_.notify_all();
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<Kind> armed_;
  bool done_ = false;
  std::function<void()> act_;
};

class CallbackRulesTest : public PubSubTest {
 protected:
  /// Runs the act in a callback of that kind, and waits until the act is done.
  void run_in(Kind kind, const Act& act, bool by_a_thread) {
    const auto in_callback = std::make_shared<ActInCallback>();
    Scene scene;
    NodeOptions options = node_options(GetParam(), "here");
    options.log_level = LogLevel::info;
    options.log = [in_callback](LogLevel, std::string_view) { in_callback->called(Kind::log); };
    scene.here = Node::open(options).value();
    scene.there = open("there");
    scene.other_node = open("other");
    const auto on_event = [in_callback](const Event&) { in_callback->called(Kind::event); };
    scene.calling_publisher =
        scene.here
            ->publisher<PointCloud2>(
                "points",
                {.on_readers_changed = [in_callback](const auto&) { in_callback->called(Kind::readers); },
                 .on_event = on_event})
            .value();
    scene.calling_subscriber =
        scene.here
            ->subscriber<PointCloud2>("samples",
                                      [in_callback](const auto&) { in_callback->called(Kind::sample); },
                                      {.on_event = on_event})
            .value();
    scene.other_publisher = scene.here->publisher<PointCloud2>("others").value();
    scene.other_subscriber = scene.here->subscriber<PointCloud2>("others").value();
    scene.far_publisher = scene.there->publisher<PointCloud2>("samples").value();
    expect_served(*scene.other_publisher, 1);
    expect_served(*scene.far_publisher, 1);
    in_callback->arm(kind, [&] {
      if (!by_a_thread) return act(scene);
      std::thread([&] { act(scene); }).join();
    });
    if (kind == Kind::sample)
      scene.far_publisher->publish({.height = 1});
    else
      scene.far_subscriber = scene.there->subscriber<PointCloud2>("points").value();
    if (!in_callback->is_done()) {
      ADD_FAILURE() << "the callback does not return";
      std::_Exit(1);
    }
  }
};

TEST_P(CallbackRulesTest, HoldInEachKindOfCallback) {
  for (const Rule& rule : rules_of_the_guide()) {
    for (const Kind kind : {Kind::sample, Kind::event, Kind::readers, Kind::log}) {
      if (kind == Kind::sample && rule.for_samples != "yes") continue;
      SCOPED_TRACE(rule.act + ", in callback " + std::to_string(static_cast<int>(kind)));
      run_in(kind, acts.at(rule.act), false);
    }
  }
}

TEST_P(CallbackRulesTest, HoldOnAThreadThatACallbackWaitsFor) {
  for (const Rule& rule : rules_of_the_guide()) {
    if (rule.by_a_thread != "yes") continue;
    for (const Kind kind : {Kind::sample, Kind::event, Kind::readers, Kind::log}) {
      SCOPED_TRACE(rule.act + ", in callback " + std::to_string(static_cast<int>(kind)));
      run_in(kind, acts.at(rule.act), true);
    }
  }
}

TEST_P(CallbackRulesTest, AWaitInACallbackForSamplesReturnsAtOnce) {
  run_in(
      Kind::sample, [](Scene& s) { EXPECT_FALSE(s.other_subscriber->wait(1h)); }, false);
}

/// A callback may destroy a subscriber whose own callback is waiting for the agent.
TEST_P(CallbackRulesTest, AnEventDestroysASubscriberWhoseCallbackAsksForTopicsMeanwhile) {
  Node here = open("here"), there = open("there");
  auto far = there.publisher<PointCloud2>("samples").value();
  std::atomic<bool> is_called{false}, may_ask{false}, has_asked{false};
  std::optional<Subscriber<PointCloud2>> subscriber;
  std::atomic<bool> is_destroyed{false}, may_destroy{false};
  auto publisher =
      here.publisher<PointCloud2>("points", {.on_event =
                                                 [&](const Event& event) {
                                                   if (event.kind != Event::Kind::matched || !may_destroy)
                                                     return;
                                                   may_ask = true;
                                                   may_ask.notify_all();
                                                   subscriber.reset();
                                                   is_destroyed = true;
                                                 }})
          .value();
  subscriber = here.subscriber<PointCloud2>("samples",
                                            [&](const auto&) {
                                              is_called = true;
                                              may_ask.wait(false);
                                              EXPECT_FALSE(here.topics().empty());
                                              has_asked = true;
                                            })
                   .value();
  expect_served(far, 1);
  far.publish({.height = 1});
  ASSERT_TRUE(eventually([&] { return is_called.load(); }));
  may_destroy = true;
  const auto match = there.subscriber<PointCloud2>("points").value();
  EXPECT_TRUE(eventually([&] { return is_destroyed.load(); }));
  EXPECT_TRUE(has_asked) << "the destructor waits for the callback";
}

/// The events of two nodes run on two threads. Each of them destroys what the other one belongs to.
TEST_P(CallbackRulesTest, EventsOfTwoNodesDestroyEachOthersNodesAtTheSameTime) {
  std::array<std::optional<Node>, 2> nodes{open("first"), open("second")};
  std::array<std::optional<Publisher<PointCloud2>>, 2> publishers;
  std::array<std::atomic<bool>, 2> is_called{};
  std::atomic<int> ended{0};
  std::barrier both(2);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    publishers[i] =
        nodes[i]
            ->publisher<PointCloud2>("points_" + std::to_string(i), {.on_event =
                                                                         [&, i](const Event&) {
                                                                           if (is_called[i].exchange(true))
                                                                             return;
                                                                           both.arrive_and_wait();
                                                                           publishers[1 - i].reset();
                                                                           nodes[1 - i].reset();
                                                                           ++ended;
                                                                         }})
            .value();
  }
  Node other = open("other");
  const auto of_first = other.subscriber<PointCloud2>("points_0").value();
  const auto of_second = other.subscriber<PointCloud2>("points_1").value();
  if (!eventually([&] { return ended == 2; })) {
    ADD_FAILURE() << "the callbacks do not return";
    std::_Exit(1);
  }
}

INSTANTIATE_TEST_SUITE_P(Ways, CallbackRulesTest, ::testing::Values(Way::shm, Way::udp), way_name);

}  // namespace
}  // namespace sft::test
