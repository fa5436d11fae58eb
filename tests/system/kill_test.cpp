// Any process that takes part is killed (kill -9) at any time. No other process crashes or hangs, memory is
// freed, and the next start works.
#include <dirent.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <sft/sft.h>
#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <set>
#include <thread>
#include <vector>

#include "shm_transport/host/host_file.h"
#include "tests/support/eventually.h"
#include "tests/support/isolated_host.h"
#include "tests/support/pace.h"
#include "tests/support/test_seed.h"

namespace sft::test {
namespace {

using sensor_msgs::msg::PointCloud2;
using F = PointCloud2::Field;
using namespace std::chrono_literals;

constexpr std::uint32_t cloud_bytes = 1'000'000;

// ---- roles of other processes ----

[[noreturn]] void publish_forever() {
  Node node = Node::open({.name = "publisher"}).value();
  auto publisher = node.publisher<PointCloud2>("points").value();
  for (std::uint32_t i = 1;; ++i) {
    auto loan = publisher.loan({.height = i}, {.data = cloud_bytes});
    if (loan) std::move(*loan).publish();
    if (i % 64 == 0) poll(nullptr, 0, 1);  // gives the core to other processes, too
  }
}

/// Takes samples and holds a limited number of them.
[[noreturn]] void subscribe_forever() {
  Node node = Node::open({.name = "subscriber"}).value();
  auto subscriber = node.subscriber<PointCloud2>("points").value();
  std::vector<Sample<PointCloud2>> held;
  for (;;) {
    subscriber.wait(1s);
    while (auto sample = subscriber.take()) held.push_back(std::move(sample));
    if (held.size() > 4) held.clear();
  }
}

/// Publishes no samples, but offers a liveliness lease. The lease of its node is so long that only the
/// lease of the publisher can expire while a test waits.
[[noreturn]] void live_forever() {
  NodeOptions options{.name = "living"};
  options.cyclonedds_config =
      "<CycloneDDS><Domain><Discovery><LeaseDuration>600 s</LeaseDuration></Discovery></Domain></CycloneDDS>";
  Node node = Node::open(options).value();
  auto publisher = node.publisher<PointCloud2>("points", {.liveliness_lease = 500ms}).value();
  for (;;) pause();
}

/// Requests all samples and takes none.
[[noreturn]] void stall_forever() {
  Node node = Node::open({.name = "stalled"}).value();
  auto subscriber = node.subscriber<PointCloud2>("points", {.reliability = reliable}).value();
  for (;;) pause();
}

/// Requests every second sample and, by a second selection, every seventh sample. Takes all of these
/// samples.
[[noreturn]] void choose_forever(TransportChoice transport) {
  Node node = Node::open({.name = "choosy", .transport = transport}).value();
  auto subscriber = node.subscriber<PointCloud2>(
                            "points", {.selection = "* @ every 2nd", .further_selections = {"@ every 7th"}})
                        .value();
  for (;;) {
    subscriber.wait(1s);
    while (subscriber.take()) {
    }
  }
}

// ---- helpers of the tests ----

class Process {
 public:
  explicit Process(const char* role) {
    char self[] = "/proc/self/exe";
    char* arguments[] = {self, const_cast<char*>("--role"), const_cast<char*>(role), nullptr};
    if (posix_spawn(&pid_, self, nullptr, nullptr, arguments, environ) != 0) pid_ = -1;
  }
  ~Process() { kill_now(); }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  /// Sends SIGSTOP or SIGCONT.
  void signal(int number) const { kill(pid_, number); }
  void kill_now() {
    if (pid_ <= 0) return;
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
    pid_ = -1;
  }

 private:
  pid_t pid_ = -1;
};

/// Returns the process ids of this host's daemons.
std::vector<pid_t> daemons() {
  std::vector<pid_t> found;
  DIR* proc = opendir("/proc");
  while (const dirent* entry = readdir(proc)) {
    std::string name;
    std::getline(std::ifstream(std::string("/proc/") + entry->d_name + "/comm"), name);
    if (name == "sftd" && std::atoi(entry->d_name) > 0) found.push_back(std::atoi(entry->d_name));
  }
  closedir(proc);
  return found;
}

/// Returns the number of programs that have a socket for the daemon. The daemon removes the socket of a
/// killed program when it frees that program's chunks.
std::size_t programs_with_sockets() {
  const std::filesystem::directory_iterator files("/tmp");
  return static_cast<std::size_t>(std::ranges::count_if(files, [](const auto& file) {
    return file.path().filename().string().starts_with(shm::runtime_name_stem);
  }));
}

class KillTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!isolation_refusal().empty()) GTEST_SKIP() << isolation_refusal();
  }

  /// Takes samples until one arrives by `way`. Returns false if no sample arrives by `way`.
  template <class S>
  static bool hears_by(S& subscriber, TransportKind way) {
    return eventually(
        [&] {
          subscriber.wait(10ms);
          while (const auto sample = subscriber.take()) {
            if (sample.info().transport == way) return true;
          }
          return false;
        },
        30s);
  }
};

TEST_F(KillTest, APublisherKilledInItsLoopIsReplacedByTheNextOneTenTimes) {
  Node node = Node::open({.name = "reader"}).value();
  auto subscriber = node.subscriber<PointCloud2, F::height>("points").value();
  for (int round = 0; round < 10; ++round) {
    Process publisher("publisher");
    ASSERT_TRUE(hears_by(subscriber, TransportKind::shm)) << "round " << round;
    publisher.kill_now();
    while (subscriber.take()) {
    }
  }
  EXPECT_EQ(daemons().size(), 1U);
}

TEST_F(KillTest, AReaderKilledWithSamplesInItsHandsCostsOtherReadersNothing) {
  Node node = Node::open({.name = "both"}).value();
  auto publisher = node.publisher<PointCloud2>("points").value();
  auto subscriber = node.subscriber<PointCloud2, F::height>("points", {.depth = 64}).value();
  std::set<std::uint64_t> served_so_far;
  const auto serves_another_by_shm = [&] {
    return std::ranges::any_of(publisher.status().readers, [&](const PublisherStatus::Reader& r) {
      return r.served && r.transport == TransportKind::shm && served_so_far.insert(r.id).second;
    });
  };
  ASSERT_TRUE(eventually(serves_another_by_shm));
  std::uint32_t published = 0;
  std::uint32_t taken = 0;
  const auto pass_one_on = [&] {
    auto loan = publisher.loan({.height = ++published}, {.data = cloud_bytes});
    ASSERT_TRUE(loan) << loan.error().message << " after " << published;
    ASSERT_EQ(std::move(*loan).publish(), PublishStatus::ok);
    ASSERT_TRUE(subscriber.wait(hang_timeout));
    const auto sample = subscriber.take();
    taken += sample->height() == published ? 1 : 0;
  };
  for (int round = 0; round < 10; ++round) {
    // Waits for the daemon, because the rounds are faster, and six killed programs would hold all chunks of
    // this size.
    ASSERT_TRUE(eventually([] { return programs_with_sockets() == 1; })) << "round " << round;
    Process other("subscriber");
    // Killed readers stay in the publisher's status until their lease ends.
    ASSERT_TRUE(eventually(serves_another_by_shm)) << "round " << round;
    for (int i = 0; i < 20; ++i) pass_one_on();
    other.kill_now();
    for (int i = 0; i < 20; ++i) pass_one_on();
  }
  EXPECT_EQ(taken, published);
  EXPECT_EQ(subscriber.status().lost, 0U);
}

TEST_F(KillTest, WhenTheDaemonIsKilledSamplesGoOnByUdpAndThenThroughANewOne) {
  Node a = Node::open({.name = "a"}).value();
  Node b = Node::open({.name = "b"}).value();
  auto publisher = a.publisher<PointCloud2>("points").value();
  auto subscriber = b.subscriber<PointCloud2, F::height>("points", {.depth = 64}).value();
  std::atomic<bool> done{false};
  std::thread publishing([&] {
    for (std::uint32_t i = 1; !done; ++i) {
      publisher.publish({.height = i});
      poll(nullptr, 0, 2);
    }
  });
  for (int round = 0; round < 3; ++round) {
    EXPECT_TRUE(hears_by(subscriber, TransportKind::shm)) << "round " << round;
    for (const pid_t daemon : daemons()) kill(daemon, SIGKILL);
    EXPECT_TRUE(hears_by(subscriber, TransportKind::udp)) << "round " << round;
  }
  EXPECT_TRUE(hears_by(subscriber, TransportKind::shm));
  done = true;
  publishing.join();
}

// Together with the three tests above and the other tests that kill daemons, a daemon is killed 30 times.
TEST_F(KillTest, OfTheDaemonAtRandomMomentsEachSampleIsTakenOnceOrCountedAndHeldOnesStayValid) {
  SCOPED_TRACE(how_to_repeat());
  Random random{test_seed()};
  Node a = Node::open({.name = "a"}).value();
  Node b = Node::open({.name = "b"}).value();
  auto publisher = a.publisher<PointCloud2>("points").value();
  auto subscriber = b.subscriber<PointCloud2, F::height>("points", {.depth = 256}).value();
  std::atomic<bool> done{false};
  std::atomic<int> failed{0};
  std::thread publishing([&] {
    for (std::uint32_t i = 1; !done; ++i) {
      if (publisher.publish({.height = i}) == PublishStatus::no_memory) ++failed;
      poll(nullptr, 0, 1);
    }
  });
  Sample<PointCloud2, F::height> held;
  std::uint64_t first = 0, last = 0;
  const auto take_until = [&](TransportKind way) {
    return eventually(
        [&] {
          subscriber.wait(10ms);
          bool came = false;
          while (auto sample = subscriber.take()) {
            EXPECT_EQ(sample->height(), sample.info().sequence);
            EXPECT_GT(sample.info().sequence, last);
            if (first == 0) first = sample.info().sequence;
            last = sample.info().sequence;
            came |= sample.info().transport == way;
            if (way == TransportKind::shm && sample.info().transport == way) held = std::move(sample);
          }
          return came;
        },
        30s);
  };
  for (int round = 0; round < 9; ++round) {
    ASSERT_TRUE(take_until(TransportKind::shm)) << "round " << round;
    const std::uint64_t sequence = held.info().sequence;
    poll(nullptr, 0, static_cast<int>(random() % 40));
    for (const pid_t daemon : daemons()) kill(daemon, SIGKILL);
    ASSERT_TRUE(take_until(TransportKind::udp)) << "round " << round;
    EXPECT_EQ(held->height(), sequence);
  }
  done = true;
  publishing.join();
  EXPECT_EQ(failed, 0);
  EXPECT_EQ(subscriber.status().received + subscriber.status().lost, last - first + 1);
}

TEST_F(KillTest, AKilledNodeIsNoticedAndNoLongerServed) {
  Node node = Node::open({.name = "publisher"}).value();
  auto publisher = node.publisher<PointCloud2>("points").value();
  Process reader("subscriber");
  ASSERT_TRUE(eventually([&] {
    const auto readers = publisher.status().readers;
    return readers.size() == 1 && readers[0].served;
  }));
  reader.kill_now();
  EXPECT_TRUE(eventually(
      [&] {
        const auto readers = publisher.status().readers;
        return readers.empty() || !readers[0].served;
      },
      10s));
}

/// Cyclone DDS keeps the announcements of the killed node for another 40 s.
TEST_F(KillTest, AKilledNodeIsNotListedByNodesThatOpenAfterwards) {
  const auto lists_points = [](Node& node) {
    const std::vector<TopicInfo> topics = node.topics();
    const auto points = std::ranges::find(topics, "points", &TopicInfo::name);
    return points != topics.end() && !points->types.empty() && !points->types[0].publishers.empty();
  };
  Node node = Node::open({.name = "looks"}).value();
  const auto subscriber = node.subscriber<PointCloud2, F::height>("points").value();
  Process publisher("publisher");
  const auto has_given_a_sign_of_life = [&] {
    const auto publishers = node.domain().publishers;
    return publishers.size() == 1 && publishers[0].progress.has_value();
  };
  ASSERT_TRUE(eventually(has_given_a_sign_of_life));
  publisher.kill_now();
  EXPECT_TRUE(eventually([&] { return !lists_points(node); }));
  Node newcomer = Node::open({.name = "looks_later"}).value();
  EXPECT_FALSE(lists_points(newcomer));
}

TEST_F(KillTest, AReaderThatIsWaitedForAndKilledIsSoonWaitedForNoMore) {
  Node node = Node::open({.name = "publisher"}).value();
  auto publisher =
      node.publisher<PointCloud2>("points", {.reliability = reliable, .max_blocking = 1s}).value();
  Process stalled("stalled");
  ASSERT_TRUE(eventually([&] {
    const auto readers = publisher.status().readers;
    return readers.size() == 1 && readers[0].served && readers[0].transport == TransportKind::shm;
  }));
  constexpr int depth = 8, samples = 1000;
  std::atomic<int> published{0};
  std::jthread publishing([&] {
    for (; published < samples; ++published) publisher.publish({});
  });
  ASSERT_TRUE(eventually([&] { return published >= depth; }));
  const auto begin = std::chrono::steady_clock::now();
  stalled.kill_now();
  publishing.join();
  EXPECT_LT(std::chrono::steady_clock::now() - begin, hang_timeout) << "not for each of its samples";
}

/// Takes samples of a subscriber with two selections on a separate thread. If the thread of the test took
/// the samples, the queue might overflow while a busy machine starts a process.
class Taking {
 public:
  using Heights = std::array<std::vector<std::uint32_t>, 2>;  ///< in the order of the selections
  explicit Taking(Subscriber<PointCloud2, F::height>& subscriber)
      : thread_([this, &subscriber](const std::stop_token& stop) {
          while (!stop.stop_requested()) {
            subscriber.wait(10ms);
            while (const auto sample = subscriber.take()) {
              taken_.at(sample.info().selection).push_back(sample->height());
              last_.at(sample.info().selection) = sample->height();
            }
          }
        }) {}

  /// Takes samples until the sample with the height `last` of each selection has arrived, and then stops.
  /// Returns the heights of all samples.
  Heights up_to(const std::array<std::uint32_t, 2>& last) {
    for (const std::size_t i : {0, 1}) EXPECT_TRUE(eventually([&] { return last_[i] == last[i]; })) << i;
    thread_.request_stop();
    thread_.join();
    return taken_;
  }

 private:
  Heights taken_;
  std::array<std::atomic<std::uint32_t>, 2> last_{};
  std::jthread thread_;
};

/// The killed reader has conditions and two selections, too, and the publisher waits for it. Samples are
/// small, because the queues of several killed readers keep some samples for a while, and shared memory
/// must still have free chunks for further samples.
TEST_F(KillTest, AReaderWithConditionsThatIsKilledInTrafficCostsTheOthersNothing) {
  SCOPED_TRACE(how_to_repeat());
  Random random{test_seed()};
  Node a = Node::open({.name = "a"}).value();
  Node b = Node::open({.name = "b"}).value();
  auto publisher = a.publisher<PointCloud2>("points", {.reliability = reliable, .max_blocking = 1s}).value();
  auto subscriber = b.subscriber<PointCloud2, F::height>("points", {.reliability = reliable,
                                                                    .depth = 256,
                                                                    .selection = "@ every 3rd",
                                                                    .further_selections = {"@ every 5th"}})
                        .value();
  std::set<std::uint64_t> served_so_far;
  const auto serves_nobody_else = [&] {
    const auto readers = publisher.status().readers;
    return std::ranges::count_if(readers, &PublisherStatus::Reader::served) == 2;
  };
  ASSERT_TRUE(eventually(serves_nobody_else));
  for (const auto& reader : publisher.status().readers) served_so_far.insert(reader.id);
  constexpr std::array<std::uint32_t, 2> every{3, 5};  // in the order of the selections
  std::atomic<std::uint32_t> published{0};
  std::atomic<int> failed{0};
  Taking taking(subscriber);
  std::optional<Ticker> traffic(std::in_place, 1ms, [&](std::uint32_t number) {
    auto loan = publisher.loan({.height = number}, {.data = 10'000});
    // If a sample replaces another one in the queue of a killed reader, the status is `dropped`, which is not
    // a failure.
    failed += loan && std::move(*loan).publish() != PublishStatus::no_memory ? 0 : 1;
    published = number;
  });
  for (int round = 0; round < 20; ++round) {
    Process other(round % 2 == 0 ? "choosy_in_memory" : "choosy_by_udp");
    // Killed readers stay in the publisher's status until their lease ends.
    ASSERT_TRUE(eventually([&] {
      return std::ranges::any_of(publisher.status().readers, [&](const PublisherStatus::Reader& reader) {
        return reader.sent > 5 && served_so_far.insert(reader.id).second;
      });
    })) << "round "
        << round;
    const std::uint32_t enough = published + static_cast<std::uint32_t>(random() % 20);
    ASSERT_TRUE(eventually([&] { return published >= enough; }));
    other.kill_now();
  }
  EXPECT_TRUE(eventually(serves_nobody_else)) << "the gates of the killed readers are asked no more";
  traffic.reset();
  Taking::Heights expected;
  for (const std::size_t i : {0, 1})
    for (std::uint32_t number = 1; number <= published; number += every[i]) expected[i].push_back(number);
  EXPECT_EQ(taking.up_to({expected[0].back(), expected[1].back()}), expected);
  EXPECT_EQ(failed, 0);
  EXPECT_EQ(publisher.status().diverted.total(), 0U) << "shared memory had no room";
  for (const std::size_t i : {0, 1}) {
    EXPECT_EQ(subscriber.status(i).lost, 0U) << i;
    EXPECT_EQ(subscriber.status(i).withheld, (every[i] - 1) * (expected[i].size() - 1)) << i;
  }
}

TEST_F(KillTest, APublisherThatIsStoppedOrKilledLosesItsLiveliness) {
  Node node = Node::open({.name = "reader"}).value();
  // The counts of events, in the order of the selections.
  std::array<std::atomic<int>, 2> lost{}, recovered{};
  const auto note = [&](const Event& event) {
    lost.at(event.selection) += event.kind == Event::Kind::liveliness_lost ? 1 : 0;
    recovered.at(event.selection) += event.kind == Event::Kind::liveliness_recovered ? 1 : 0;
  };
  const auto both = [](const std::array<std::atomic<int>, 2>& counts, int count) {
    return counts[0] == count && counts[1] == count;
  };
  auto subscriber =
      node.subscriber<PointCloud2, F::height>(
              "points", {.liveliness_lease = 1s, .further_selections = {"@ every 2nd"}, .on_event = note})
          .value();
  Process publisher("living");
  for (const std::size_t i : {0, 1})
    ASSERT_TRUE(eventually([&] { return subscriber.status(i).writers.size() == 1; })) << i;
  EXPECT_FALSE(eventually([&] { return !both(lost, 0); }, 1500ms));
  publisher.signal(SIGSTOP);
  EXPECT_TRUE(eventually([&] { return both(lost, 1); }));
  publisher.signal(SIGCONT);
  EXPECT_TRUE(eventually([&] { return both(recovered, 1); }));
  publisher.kill_now();
  EXPECT_TRUE(eventually([&] { return both(lost, 2); }));
}

}  // namespace
}  // namespace sft::test

int main(int argc, char** argv) {
  const std::string role = argc == 3 && std::strcmp(argv[1], "--role") == 0 ? argv[2] : "";
  if (role == "publisher") sft::test::publish_forever();
  if (role == "stalled") sft::test::stall_forever();
  if (role == "living") sft::test::live_forever();
  if (role == "subscriber") sft::test::subscribe_forever();
  if (role == "choosy_in_memory") sft::test::choose_forever(sft::TransportChoice::shm);
  if (role == "choosy_by_udp") sft::test::choose_forever(sft::TransportChoice::udp);
  ::testing::InitGoogleTest(&argc, argv);
  if (GTEST_FLAG_GET(list_tests)) return RUN_ALL_TESTS();
  return sft::test::run_isolated([] { return RUN_ALL_TESTS(); });
}
