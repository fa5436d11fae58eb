// A daemon is killed or stopped while nodes use it, and the next daemon starts. The nodes continue over UDP
// and return to shared memory. No sample is taken twice, and each missed sample is counted. Samples and
// loans that the program holds stay valid.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <sft/sft.h>
#include <algorithm>
#include <array>
#include <cstdio>
#include <memory>
#include <optional>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <thread>
#include <utility>
#include <vector>

#include "tests/support/eventually.h"
#include "tests/support/isolated_host.h"
#include "tests/support/test_seed.h"

namespace sft::test {
namespace {

using sensor_msgs::msg::PointCloud2;
using F = PointCloud2::Field;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

NodeOptions without_starting_one(const std::string& name) {
  NodeOptions options{.name = name};
  options.shm.start_daemon = false;
  return options;
}

enum class End { killed, stopped };

/// A process of sftd, which is ended by the destructor.
class Sftd {
 public:
  /// Starts sftd. Returns when sftd reports that it is ready.
  Sftd() {
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0) std::abort();
    pid_ = run({"--foreground", "--log-level=error", "--pool-mib=64"}, ends[1]);
    close(ends[1]);
    FILE* output = fdopen(ends[0], "r");
    char line[64]{};
    EXPECT_STREQ(std::fgets(line, sizeof line, output), "sftd: ready\n");
    ready_at_ = Clock::now();
    std::fclose(output);
  }
  ~Sftd() { end(End::killed); }
  Sftd(const Sftd&) = delete;
  Sftd& operator=(const Sftd&) = delete;

  Clock::time_point ready_at() const { return ready_at_; }
  void end(End how) {
    if (pid_ <= 0) return;
    if (how == End::killed) {
      kill(pid_, SIGKILL);
    } else {
      wait_for(run({"stop"}, -1));
    }
    wait_for(std::exchange(pid_, -1));
  }

 private:
  static pid_t run(std::vector<std::string> words, int output) {
    words.insert(words.begin(), program_directory() + "/sftd");
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    if (output >= 0)
      posix_spawn_file_actions_adddup2(&actions, output, STDOUT_FILENO);
    else
      posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    pid_t pid = -1;
    EXPECT_EQ(posix_spawn(&pid, arguments[0], &actions, nullptr, arguments.data(), environ), 0);
    posix_spawn_file_actions_destroy(&actions);
    return pid;
  }
  static void wait_for(pid_t pid) { waitpid(pid, nullptr, 0); }

  pid_t pid_ = -1;
  Clock::time_point ready_at_;
};

/// A process that publishes a sample each millisecond.
class PublishingProcess {
 public:
  /// REQUIRES: this process has no other threads yet.
  PublishingProcess() {
    pid_ = fork();
    if (pid_ != 0) return;
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    Node node = Node::open(without_starting_one("publisher")).value();
    auto publisher = node.publisher<PointCloud2>("points").value();
    for (std::uint32_t i = 1;; ++i) {
      publisher.publish({.height = i});
      poll(nullptr, 0, 1);
    }
  }
  ~PublishingProcess() {
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  PublishingProcess(const PublishingProcess&) = delete;
  PublishingProcess& operator=(const PublishingProcess&) = delete;

 private:
  pid_t pid_ = -1;
};

/// A subscriber in this process with two selections, and a record of the samples that arrived for each
/// selection.
class Reading {
 public:
  /// Takes samples until one has arrived by the transport `way` for each selection. Returns the time at
  /// which the last of these samples was taken, or nothing if these samples do not arrive.
  std::optional<Clock::time_point> hears_by(TransportKind way) {
    std::array<bool, 2> heard{};
    std::optional<Clock::time_point> all_heard;
    eventually([&] {
      subscriber_.wait(10ms);
      while (const auto sample = subscriber_.take()) {
        note(sample.info());
        heard.at(sample.info().selection) |= sample.info().transport == way;
        if (heard[0] && heard[1] && !all_heard) all_heard = Clock::now();
      }
      return all_heard.has_value();
    });
    return all_heard;
  }
  /// Returns success if each selection took each sample between its first and last sample once and in
  /// order, or counted it as lost.
  testing::AssertionResult accounts_for_all() const {
    for (const std::size_t i : {0, 1}) {
      const Taken& taken = taken_[i];
      const std::uint64_t published = taken.last - taken.first + 1;
      const std::uint64_t lost = subscriber_.status(i).lost;
      if (taken.disordered != 0 || taken.samples + lost != published) {
        return testing::AssertionFailure()
               << "selection " << i << ": " << published << " published, " << taken.samples << " taken, "
               << lost << " lost, " << taken.disordered << " repeated or out of order";
      }
    }
    return testing::AssertionSuccess();
  }
  std::uint64_t lost() const { return subscriber_.status().lost; }

 private:
  struct Taken {
    std::uint64_t first = 0, last = 0, samples = 0, disordered = 0;
  };
  void note(const SampleInfo& info) {
    Taken& taken = taken_.at(info.selection);
    if (taken.samples++ == 0) taken.first = info.sequence;
    if (info.sequence <= taken.last) ++taken.disordered;
    taken.last = info.sequence;
  }

  Node node_ = Node::open(without_starting_one("reader")).value();
  Subscriber<PointCloud2, selected> subscriber_ =
      node_
          .subscriber<PointCloud2, selected>(
              "points", {.depth = 4096, .selection = "height", .further_selections = {"width"}})
          .value();
  std::array<Taken, 2> taken_;
};

class DaemonLoss : public testing::Test {
 protected:
  void SetUp() override {
    if (!isolation_refusal().empty()) GTEST_SKIP() << isolation_refusal();
  }
};

std::chrono::milliseconds in_ms(Clock::duration duration) {
  return std::chrono::duration_cast<std::chrono::milliseconds>(duration);
}

TEST_F(DaemonLoss, IsOverOnceTheNextOneIsReadyAndCostsNothingUncounted) {
  const PublishingProcess publisher;
  Reading reader;
  std::vector<std::chrono::milliseconds> returns;
  auto daemon = std::make_unique<Sftd>();
  ASSERT_TRUE(reader.hears_by(TransportKind::shm));
  for (std::uint64_t i = 0; i < test_rounds(6); ++i) {
    daemon->end(i % 2 == 0 ? End::killed : End::stopped);
    ASSERT_TRUE(reader.hears_by(TransportKind::udp)) << "round " << i;
    daemon = std::make_unique<Sftd>();
    const auto heard = reader.hears_by(TransportKind::shm);
    ASSERT_TRUE(heard) << "round " << i;
    returns.push_back(in_ms(*heard - daemon->ready_at()));
  }
  EXPECT_TRUE(reader.accounts_for_all());
  std::ranges::sort(returns);
  std::printf("back in shared memory after %ld ms (median), %ld ms (max); %lu samples lost\n",
              static_cast<long>(returns[returns.size() / 2].count()),
              static_cast<long>(returns.back().count()), static_cast<unsigned long>(reader.lost()));
}

constexpr std::uint32_t cloud_bytes = 1'000'000;

std::uint8_t byte_at(std::uint32_t number, std::size_t i) {
  return static_cast<std::uint8_t>(number + i / 7);
}

template <class Data>
bool is_cloud(std::uint32_t number, const Data& data) {
  for (std::size_t i = 0; i < data.size(); ++i) {
    if (data[i] != byte_at(number, i)) return false;
  }
  return data.size() == cloud_bytes;
}

/// Two nodes in this process. The height of a cloud is its number.
class Pair {
 public:
  using Cloud = Loan<PointCloud2>;
  using Taken = Sample<PointCloud2, F::height | F::data>;

  Cloud cloud(std::uint32_t number) {
    auto loan = publisher_.loan({.height = number}, {.data = cloud_bytes});
    const auto data = loan.value()->data();
    for (std::size_t i = 0; i < data.size(); ++i) data[i] = byte_at(number, i);
    return std::move(*loan);
  }
  /// Publishes the loan, and takes samples until that sample arrives.
  Taken pass_on(Cloud loan, std::uint32_t number) {
    EXPECT_EQ(std::move(loan).publish(), PublishStatus::ok) << "cloud " << number;
    Taken taken;
    EXPECT_TRUE(eventually([&] {
      subscriber_.wait(10ms);
      taken = subscriber_.take();
      return taken && taken->height() == number;
    })) << "cloud "
        << number;
    return taken;
  }
  /// Publishes and takes clouds until one arrives by that transport. Returns false if no cloud arrives by
  /// that transport.
  bool goes_by(TransportKind way) {
    return eventually([&] {
      const Taken taken = pass_on(cloud(1), 1);
      return taken.info().transport == way;
    });
  }
  bool is_served() const {
    const auto readers = publisher_.status().readers;
    return readers.size() == 1 && readers[0].served;
  }

 private:
  Node a_ = Node::open(without_starting_one("a")).value();
  Node b_ = Node::open(without_starting_one("b")).value();
  Publisher<PointCloud2> publisher_ = a_.publisher<PointCloud2>("points").value();
  Subscriber<PointCloud2, F::height | F::data> subscriber_ =
      b_.subscriber<PointCloud2, F::height | F::data>("points").value();
};

class HeldMemory : public DaemonLoss, public testing::WithParamInterface<End> {};

TEST_P(HeldMemory, StaysWhatItIsAndLoansCanStillBePublished) {
  Pair pair;
  auto daemon = std::make_unique<Sftd>();
  ASSERT_TRUE(eventually([&] { return pair.is_served(); }));
  ASSERT_TRUE(pair.goes_by(TransportKind::shm));
  std::vector<Pair::Taken> held;
  for (std::uint32_t number = 10; number < 13; ++number) {
    held.push_back(pair.pass_on(pair.cloud(number), number));
    ASSERT_EQ(held.back().info().transport, TransportKind::shm);
  }
  std::vector<Pair::Cloud> loans;
  for (std::uint32_t number = 20; number < 23; ++number) loans.push_back(pair.cloud(number));

  daemon->end(GetParam());
  const Pair::Taken at_once = pair.pass_on(std::move(loans[0]), 20);
  ASSERT_TRUE(pair.goes_by(TransportKind::udp));
  const Pair::Taken without = pair.pass_on(std::move(loans[1]), 21);
  EXPECT_EQ(without.info().transport, TransportKind::udp);
  daemon = std::make_unique<Sftd>();
  ASSERT_TRUE(pair.goes_by(TransportKind::shm));
  for (int i = 0; i < 50; ++i) pair.pass_on(pair.cloud(2), 2);
  const Pair::Taken with_the_next = pair.pass_on(std::move(loans[2]), 22);
  EXPECT_EQ(with_the_next.info().transport, TransportKind::shm);

  EXPECT_TRUE(is_cloud(20, at_once->data()));
  EXPECT_TRUE(is_cloud(21, without->data()));
  EXPECT_TRUE(is_cloud(22, with_the_next->data()));
  for (std::uint32_t i = 0; i < held.size(); ++i) EXPECT_TRUE(is_cloud(10 + i, held[i]->data())) << i;
}

INSTANTIATE_TEST_SUITE_P(OfADaemon, HeldMemory, testing::Values(End::killed, End::stopped),
                         [](const auto& end) {
                           return end.param == End::killed ? "ThatIsKilled" : "ThatIsStopped";
                         });

/// Returns how often threads of this process have gone to sleep so far.
long wakes_of_all_threads() {
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  return used.ru_nvcsw;
}

TEST_F(DaemonLoss, LeavesANodeThatWaitsIdle) {
  Node node = Node::open(without_starting_one("reader")).value();
  auto subscriber = node.subscriber<PointCloud2>("points").value();
  EXPECT_FALSE(subscriber.wait(1s)) << "discovery has settled";
  const long before = wakes_of_all_threads();
  EXPECT_FALSE(subscriber.wait(4s));
  EXPECT_LT(wakes_of_all_threads() - before, 220)
      << "in 4 s; `./run bench many --only idle` measures the time";
}

}  // namespace
}  // namespace sft::test
