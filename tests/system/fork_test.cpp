// fork() in a program with nodes. Whatever the child does with its copies of the nodes, the parent's nodes
// continue undisturbed.
#include <sanitizer/lsan_interface.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "tests/system/fixture.h"

namespace {
bool is_forked = false;  ///< true in the processes that the tests fork
}

/// The leak sanitizer asks for this when a program exits. A forked process is without the threads of its
/// parent, on whose stacks the only references to some of the memory are.
int __lsan_is_turned_off() { return is_forked ? 1 : 0; }  // NOLINT: the sanitizer gives the name

namespace sft::test {
namespace {

/// One object of each kind that a program can get from a node.
struct Held {
  Node writing, reading;
  Publisher<PointCloud2> publisher;
  Subscriber<PointCloud2, F::height> subscriber;
  Subscriber<PointCloud2, F::height> called_back;
  std::optional<Sample<PointCloud2, F::height>> sample{};
  std::optional<Loan<PointCloud2>> loan{};
};
std::optional<Held> held;  // exit() destroys it

/// Returns the files by which other processes reach this process: its doorbells, and its sockets to the
/// daemon.
std::vector<std::string> shared_files() {
  std::vector<std::string> names;
  for (const char* directory : {"/dev/shm", "/tmp"}) {
    for (const auto& entry : std::filesystem::directory_iterator(directory)) {
      const std::string name = entry.path().filename();
      if (name.starts_with("sft_bell_") || name.starts_with("sft_node_")) names.push_back(name);
    }
  }
  std::ranges::sort(names);
  return names;
}

class ForkTest : public PubSubTest {
 protected:
  void SetUp() override {
    warnings_expected = true;  // a busy machine starts the daemon late
    Node writing = open("writing");
    Node reading = open("reading");
    const auto note = [this](const Event& event) {
      if (event.kind == Event::Kind::unmatched || event.kind == Event::Kind::path_changed) ++disturbances_;
    };
    auto publisher = writing.publisher<PointCloud2>("points", {.on_event = note}).value();
    auto subscriber = reading.subscriber<PointCloud2, F::height>("points", {.on_event = note}).value();
    auto called_back =
        reading.subscriber<PointCloud2, F::height>("points", [this](const auto&) { ++called_; }).value();
    expect_served(publisher, 2);
    warnings_expected = false;
    held.emplace(Held{writing, reading, std::move(publisher), std::move(subscriber), std::move(called_back)});
    held->publisher.publish({.height = 1});
    ASSERT_TRUE(held->subscriber.wait(hang_timeout));
    held->sample = held->subscriber.take();
    held->loan = held->publisher.loan({.height = 2}, {.data = 100}).value();
    files_ = shared_files();
  }
  void TearDown() override { held.reset(); }

  /// Runs `act` in a forked process. Returns its exit code, or the negative number of the signal that ended
  /// it.
  static int forked(const std::function<void()>& act) {
    const pid_t child = fork();
    if (child == 0) {
      is_forked = true;
      alarm(20);  // ends the process if `act` hangs
      act();
      _exit(0);
    }
    int status = 0;
    waitpid(child, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }

  /// Expects that the parent's pair still works, and has all its files and samples.
  void expect_undisturbed() {
    EXPECT_EQ(shared_files(), files_);
    EXPECT_EQ(held->sample ? (*held->sample)->height() : 0, 1U);
    const int called_before = called_;
    for (std::uint32_t i = 1; i <= 100; ++i) {
      ASSERT_EQ(held->publisher.publish({.height = i}), PublishStatus::ok);
      ASSERT_TRUE(held->subscriber.wait(hang_timeout)) << i;
      const auto sample = held->subscriber.take();
      EXPECT_EQ(sample->height(), i);
      EXPECT_EQ(sample.info().lost_before, 0U);
      ASSERT_TRUE(eventually([&] { return called_ >= called_before + static_cast<int>(i); })) << i;
    }
    // This request is sent later than any message that the child might have sent to the daemon or to other
    // nodes.
    const auto later = held->reading.subscriber<PointCloud2, F::height>("points").value();
    expect_served(held->publisher, 3);
    EXPECT_EQ(disturbances_, 0);
  }

 private:
  std::atomic<int> called_{0}, disturbances_{0};
  std::vector<std::string> files_;
};

TEST_P(ForkTest, AProcessThatExitsWithStaticDestructorsLeavesTheNodesOfItsParentAlone) {
  EXPECT_EQ(forked([] { std::exit(7); }), 7);
  expect_undisturbed();
}

TEST_P(ForkTest, AProcessMayDestroyWhatItFindsInAnyOrder) {
  EXPECT_EQ(forked([] {
              held->sample.reset();
              held->loan.reset();
              held.reset();
            }),
            0);
  EXPECT_EQ(forked([] {
              {
                const Node gone = std::move(held->reading);
                const auto publisher = std::move(held->publisher);
                const auto subscriber = std::move(held->subscriber);
              }
              held.reset();
            }),
            0);
  expect_undisturbed();
}

TEST_P(ForkTest, AProcessMayBeginAnotherProgram) {
  EXPECT_EQ(forked([] { execl("/bin/sh", "sh", "-c", "exit 5", nullptr); }), 5);
  expect_undisturbed();
}

TEST_P(ForkTest, AProcessThatOpensANodeIsToldWhyItCannot) {
  EXPECT_EQ(forked([] {
              const auto node = Node::open({.name = "child"});
              if (node || node.error().code != Errc::unavailable) _exit(1);
              if (node.error().message.find("this process was forked from one that has a node") ==
                  std::string::npos)
                _exit(2);
            }),
            0);
  expect_undisturbed();
}

/// daemon(3) forks, and the program continues in the child.
TEST_P(ForkTest, AProcessThatGoesOnWithWhatItFindsIsToldWhyNothingWorks) {
  EXPECT_EQ(forked([] {
              const auto refuses = [](const auto& result) {
                return !result && result.error().message.starts_with("this process was forked");
              };
              Held& h = *held;
              const std::vector<bool> as_promised{
                  h.publisher.publish({.height = 3}) == PublishStatus::forked,
                  h.publisher.publish(std::vector<PointCloud2>(2)).status == PublishStatus::forked,
                  std::move(*h.loan).publish() == PublishStatus::forked,
                  refuses(h.publisher.loan({})),
                  !h.publisher.wait_for_subscribers(1, hang_timeout),
                  h.publisher.status().readers.empty(),
                  !h.subscriber.wait(hang_timeout),
                  !h.subscriber.take(),
                  !h.subscriber.take_latest(),
                  refuses(h.subscriber.set_max_rate_hz(1)),
                  h.subscriber.status().writers.empty(),
                  refuses(h.writing.publisher<PointCloud2>("more")),
                  refuses(h.writing.subscriber<PointCloud2>("more")),
                  refuses(h.writing.find_type("points", hang_timeout)),
                  refuses(h.writing.ask_accounts("points")),
                  h.writing.topics().empty(),
                  h.writing.domain().publishers.empty(),
                  h.writing.status().udp.starts_with("this process was forked"),
                  h.writing.snapshot().publishers.empty(),
              };
              for (std::size_t i = 0; i < as_promised.size(); ++i) {
                if (!as_promised[i]) _exit(static_cast<int>(i) + 1);
              }
            }),
            0)
      << "the number of what was not as told, from 1 on";
  expect_undisturbed();
}

TEST_P(ForkTest, ManyProcessesThatComeAndGoWhileSamplesAreSentDisturbNobody) {
  std::atomic<bool> stop{false};
  Publisher<PointCloud2> another = held->writing.publisher<PointCloud2>("others").value();
  const auto reader = held->reading.subscriber<PointCloud2, F::height>("others", [](const auto&) {}).value();
  std::thread publishing([&] {
    while (!stop) another.publish({.height = 3});
  });
  for (int i = 0; i < 20; ++i) EXPECT_EQ(forked([] { std::exit(7); }), 7) << i;
  stop = true;
  publishing.join();
  expect_undisturbed();
}

INSTANTIATE_TEST_SUITE_P(Ways, ForkTest, ::testing::Values(Way::shm, Way::udp), way_name);

}  // namespace
}  // namespace sft::test
