// The threads of a node: their names, CPUs and scheduling policies. These do not depend on the thread that
// opens the node.
#include <gmock/gmock.h>
#include <sched.h>
#include <sys/resource.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <thread>

#include "tests/support/isolated_host.h"
#include "tests/system/fixture.h"

namespace sft::test {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsSupersetOf;

struct Thread {
  std::string name;
  int policy = 0;
  int priority = 0;
  std::set<unsigned> cpus{};
};

std::set<unsigned> cpus_of(pid_t thread) {
  cpu_set_t set;
  std::set<unsigned> cpus;
  if (sched_getaffinity(thread, sizeof set, &set) != 0) return cpus;
  for (unsigned cpu = 0; cpu < CPU_SETSIZE; ++cpu) {
    if (CPU_ISSET(cpu, &set)) cpus.insert(cpu);
  }
  return cpus;
}

/// Returns the threads of this process by their thread ids.
std::map<pid_t, Thread> threads() {
  std::map<pid_t, Thread> threads;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/task")) {
    const pid_t number = std::stoi(entry.path().filename());
    Thread& thread = threads[number];
    std::getline(std::ifstream(entry.path() / "comm"), thread.name);
    thread.policy = sched_getscheduler(number);
    sched_param parameters{};
    sched_getparam(number, &parameters);
    thread.priority = parameters.sched_priority;
    thread.cpus = cpus_of(number);
  }
  return threads;
}

std::set<std::string> names(const std::map<pid_t, Thread>& threads) {
  std::set<std::string> names;
  for (const auto& [number, thread] : threads) names.insert(thread.name);
  return names;
}

bool become_real_time() {
  const sched_param parameters{.sched_priority = 10};
  return sched_setscheduler(0, SCHED_FIFO, &parameters) == 0;
}
void become_normal() {
  const sched_param parameters{};
  sched_setscheduler(0, SCHED_OTHER, &parameters);
}

bool pin_to(const std::set<unsigned>& cpus) {
  cpu_set_t set;
  CPU_ZERO(&set);
  for (const unsigned cpu : cpus) CPU_SET(cpu, &set);
  return sched_setaffinity(0, sizeof set, &set) == 0;
}

/// Tests with nodes that have all threads that a node can have, because they have a callback, a file
/// descriptor, and several readers that sleep.
class ThreadsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!isolation_refusal().empty()) GTEST_SKIP() << isolation_refusal();
    warnings_expected = false;
  }

  static NodeOptions options(const std::string& name) {
    NodeOptions options = node_options(Way::shm, name);
    options.transport = TransportChoice::automatic;
    return options;
  }

  /// Opens a node with these options and uses it. Returns the threads that it has added to the process.
  std::map<pid_t, Thread> threads_of(const NodeOptions& options) {
    const auto before = threads();
    Node node = Node::open(options).value();
    auto publisher = node.publisher<PointCloud2>("points").value();
    std::atomic<int> called{0};
    const auto count = [&](const auto&) { ++called; };
    auto by_callback = node.subscriber<PointCloud2, F::height>("points", count).value();
    auto by_descriptor = node.subscriber<PointCloud2, F::height>("points", {.pollable = true}).value();
    auto by_udp =
        node.subscriber<PointCloud2, F::height>("points", count, {.transport = TransportChoice::udp}).value();
    EXPECT_TRUE(eventually([&] {
      const auto readers = publisher.status().readers;
      return readers.size() == 3 &&
             std::ranges::count(readers, TransportKind::shm, &PublisherStatus::Reader::transport) == 2;
    }));
    EXPECT_TRUE(eventually([&] {
      publisher.publish({.height = 1});
      return called > 10;
    }));
    // A thread sets its name shortly after it was started. The thread that wakes readers is started last.
    std::map<pid_t, Thread> now;
    EXPECT_TRUE(eventually([&] {
      now = threads();
      return std::ranges::any_of(names(now), [](const std::string& name) { return name.ends_with("wake"); });
    }));
    std::erase_if(now, [&](const auto& entry) { return before.contains(entry.first); });
    // Workers of io_uring belong to the kernel.
    std::erase_if(now, [](const auto& entry) { return entry.second.name.starts_with("iou-"); });
    return now;
  }
};

TEST_F(ThreadsTest, OfANodeThatAPinnedRealTimeThreadOpensAreNormalAndRunWhereTheProgramMay) {
  const std::set<unsigned> all = cpus_of(0);
  std::map<pid_t, Thread> found;
  bool real_time = false;
  std::thread opener([&] {
    real_time = become_real_time();
    pin_to({*all.begin()});
    if (real_time) found = threads_of(options("a"));
  });
  opener.join();
  if (!real_time) GTEST_SKIP() << "needs CAP_SYS_NICE";
  EXPECT_THAT(names(found), IsSupersetOf({"sft-udp-recv", "sft-udp-send", "sft-agent a", "sft-call a",
                                          "sft-poll a", "sft-event a", "sft-wake"}));
  EXPECT_GE(found.size(), 10U) << "Cyclone's are among them";
  for (const auto& [number, thread] : found) {
    EXPECT_EQ(thread.policy, SCHED_OTHER) << thread.name;
    EXPECT_EQ(thread.cpus, all) << thread.name;
  }
}

TEST_F(ThreadsTest, HaveWhatTheOptionsSayAndNamesThatBeginAsTheySay) {
  const unsigned cpu = *cpus_of(0).rbegin();
  NodeOptions with = options("a");
  with.threads.receiver = {
      .cpus = {cpu}, .policy = ThreadSettings::Policy::fifo, .priority = 5, .name_prefix = "r-"};
  with.threads.sender = {.policy = ThreadSettings::Policy::round_robin, .priority = 4, .name_prefix = "s-"};
  with.threads.agent = {.cpus = {cpu}, .name_prefix = "a-"};
  with.threads.callbacks = {.policy = ThreadSettings::Policy::fifo, .priority = 3, .name_prefix = "c-"};
  with.threads.discovery = {
      .cpus = {cpu}, .policy = ThreadSettings::Policy::fifo, .priority = 2, .name_prefix = "d-"};
  const bool may = become_real_time();
  become_normal();
  if (!may) GTEST_SKIP() << "needs CAP_SYS_NICE";
  const std::set<unsigned> all = cpus_of(0);
  const auto found = threads_of(with);
  const std::map<std::string, Thread> expected{
      {"r-udp-recv", {"", SCHED_FIFO, 5, {cpu}}}, {"s-udp-send", {"", SCHED_RR, 4, all}},
      {"s-wake", {"", SCHED_RR, 4, all}},         {"a-agent a", {"", SCHED_OTHER, 0, {cpu}}},
      {"c-call a", {"", SCHED_FIFO, 3, all}},     {"c-poll a", {"", SCHED_FIFO, 3, all}},
      {"c-event a", {"", SCHED_FIFO, 3, all}}};
  std::size_t of_cyclone = 0;
  for (const auto& [number, thread] : found) {
    const bool is_cyclones = !expected.contains(thread.name);
    EXPECT_TRUE(!is_cyclones || thread.name.starts_with("d-")) << thread.name;
    of_cyclone += is_cyclones ? 1 : 0;
    const Thread wanted = is_cyclones ? Thread{"", SCHED_FIFO, 2, {cpu}} : expected.at(thread.name);
    EXPECT_EQ(thread.policy, wanted.policy) << thread.name;
    EXPECT_EQ(thread.priority, wanted.priority) << thread.name;
    EXPECT_EQ(thread.cpus, wanted.cpus) << thread.name;
  }
  EXPECT_GE(of_cyclone, 4U);
  for (const auto& [name, thread] : expected) EXPECT_THAT(names(found), Contains(name));
}

TEST_F(ThreadsTest, ADaemonThatARealTimeThreadStartsIsNormalAndRunsWhereTheProgramMay) {
  NodeOptions with = options("a");
  with.threads.agent = {.cpus = {*cpus_of(0).begin()}, .policy = ThreadSettings::Policy::fifo, .priority = 1};
  const bool may = become_real_time();
  become_normal();
  if (!may) GTEST_SKIP() << "needs CAP_SYS_NICE";
  const Node node = Node::open(with).value();
  ASSERT_TRUE(eventually([&] { return node.status().shm_ready; }));
  const auto processes = [] {
    std::vector<pid_t> found;
    for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
      std::string name;
      std::getline(std::ifstream(entry.path() / "comm"), name);
      if (name == "sftd") found.push_back(std::stoi(entry.path().filename()));
    }
    return found;
  }();
  ASSERT_EQ(processes.size(), 1U);
  EXPECT_EQ(sched_getscheduler(processes[0]), SCHED_OTHER);
  EXPECT_EQ(cpus_of(processes[0]), cpus_of(0));
}

TEST_F(ThreadsTest, SettingsThatMakeNoSenseAreAnErrorThatNamesThem) {
  const auto error_of = [](const NodeOptions::Threads& threads) {
    NodeOptions with = options("a");
    with.threads = threads;
    const auto node = Node::open(with);
    return node ? std::string("it opens") : node.error().message;
  };
  EXPECT_THAT(
      error_of({.sender = {.priority = 5}}),
      HasSubstr(
          "NodeOptions::threads.sender: the priority 5 is wrong: it is 1 to 99 under the policies fifo"));
  EXPECT_THAT(error_of({.agent = {.policy = ThreadSettings::Policy::fifo}}),
              HasSubstr("NodeOptions::threads.agent: the priority 0 is wrong"));
  EXPECT_THAT(error_of({.callbacks = {.policy = ThreadSettings::Policy::round_robin, .priority = 100}}),
              HasSubstr("NodeOptions::threads.callbacks: the priority 100 is wrong"));
  EXPECT_THAT(error_of({.receiver = {.cpus = {0, 8000}}}),
              HasSubstr("NodeOptions::threads.receiver: this process may not use CPU 8000"));
  EXPECT_THAT(error_of({.discovery = {.cpus = {1'000'000}}}),
              HasSubstr("NodeOptions::threads.discovery: there is no CPU 1000000"));
}

TEST_F(ThreadsTest, APolicyThatTheSystemRefusesIsAnErrorThatSaysWhatToDo) {
  const rlimit none{};
  setrlimit(RLIMIT_RTPRIO, &none);
  if (getuid() == 0 && setresuid(61'235, 61'235, 61'235) != 0) GTEST_SKIP() << "cannot become another user";
  if (become_real_time()) GTEST_SKIP() << "this program may do everything";
  NodeOptions with = options("a");
  with.threads.receiver = {.policy = ThreadSettings::Policy::fifo, .priority = 42};
  const auto node = Node::open(with);
  ASSERT_FALSE(node);
  EXPECT_EQ(node.error().code, Errc::no_permission);
  EXPECT_THAT(
      node.error().message,
      HasSubstr("NodeOptions::threads.receiver: the system refuses the policy fifo with priority 42: "
                "Operation not permitted; give the program CAP_SYS_NICE, or raise its limit RLIMIT_RTPRIO to "
                "42 or more"));
}

}  // namespace
}  // namespace sft::test
