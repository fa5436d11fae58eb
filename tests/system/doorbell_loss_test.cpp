// A publisher cannot open the doorbell of readers in shared memory. The readers then receive by UDP, both
// sides continue, and the publisher logs the reason. The readers return to shared memory once the doorbell
// can be opened.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <sft/sft.h>
#include <algorithm>
#include <filesystem>
#include <functional>
#include <mutex>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <string>
#include <vector>

#include "tests/support/eventually.h"
#include "tests/support/isolated_host.h"

namespace sft::test {
namespace {

using sensor_msgs::msg::PointCloud2;
using F = PointCloud2::Field;
using namespace std::chrono_literals;

/// A process that takes clouds and publishes each again. The width of the published cloud is the number of
/// the transport by which the original cloud arrived. The process starts when it reads the first byte from
/// its pipe.
class Listening {
 public:
  /// REQUIRES: this process has no other threads yet.
  Listening() {
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0) std::abort();
    pid_ = fork();
    if (pid_ == 0) run(ends[0]);
    close(ends[0]);
    start_ = ends[1];
  }
  ~Listening() {
    close(start_);
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  Listening(const Listening&) = delete;
  Listening& operator=(const Listening&) = delete;

  void begin() const { EXPECT_EQ(write(start_, "x", 1), 1); }

 private:
  [[noreturn]] static void run(int begin) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    char byte = 0;
    if (read(begin, &byte, 1) != 1) _exit(1);
    Node node = Node::open({.name = "listener"}).value();
    auto answers = node.publisher<PointCloud2>("answers", {.transport = TransportChoice::udp}).value();
    auto points = node.subscriber<PointCloud2, F::height>("points").value();
    for (;;) {
      points.wait(1h);  // until the process is woken
      while (const auto sample = points.take()) {
        const auto way = static_cast<std::uint32_t>(sample.info().transport);
        answers.publish({.height = sample->height(), .width = way});
      }
    }
  }

  pid_t pid_ = -1;
  int start_ = -1;
};

class DoorbellLoss : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!isolation_refusal().empty()) GTEST_SKIP() << isolation_refusal();
  }

  NodeOptions options() {
    NodeOptions options{.name = "talker"};
    options.log = [this](LogLevel level, std::string_view text) {
      const std::scoped_lock lock(mutex_);
      if (level == LogLevel::warning) warnings_.emplace_back(text);
    };
    return options;
  }
  std::size_t warned_of(const std::string& what) {
    const std::scoped_lock lock(mutex_);
    return static_cast<std::size_t>(std::ranges::count_if(
        warnings_, [&](const std::string& line) { return line.find(what) != std::string::npos; }));
  }

  std::mutex mutex_;
  std::vector<std::string> warnings_;
};

/// A publisher, and a subscriber to the answers of its listeners.
class Talking {
 public:
  explicit Talking(const NodeOptions& options) : node_(Node::open(options).value()) {}

  /// Publishes until `listeners` listeners have received the same sample by `way` within 50 ms.
  bool is_heard(TransportKind way, std::size_t listeners = 1) {
    return is_heard_by(listeners, [way](TransportKind came) { return came == way; });
  }
  /// Does the same as is_heard() for samples by any transport.
  bool is_heard_by(std::size_t listeners) {
    return is_heard_by(listeners, [](TransportKind) { return true; });
  }
  std::vector<PublisherStatus::Reader> readers() const { return publisher_.status().readers; }
  bool shm_is_ready() {
    return eventually([&] { return node_.status().shm_ready; }, 30s);
  }

 private:
  template <class Counts>
  bool is_heard_by(std::size_t listeners, const Counts& counts) {
    return eventually(
        [&] {
          publisher_.publish({.height = ++number_});
          std::size_t heard = 0;
          for (const auto deadline = std::chrono::steady_clock::now() + 50ms;
               heard < listeners && std::chrono::steady_clock::now() < deadline;) {
            answers_.wait(10ms);
            while (const auto answer = answers_.take())
              heard += answer->height() == number_ && counts(static_cast<TransportKind>(answer->width()));
          }
          return heard == listeners;
        },
        30s);
  }

  Node node_;
  Publisher<PointCloud2> publisher_ = node_.publisher<PointCloud2>("points").value();
  Subscriber<PointCloud2, F::height | F::width> answers_ =
      node_.subscriber<PointCloud2, F::height | F::width>("answers", {.depth = 64}).value();
  std::uint32_t number_ = 0;
};

/// While this object lives, the process cannot open further files. (Discovery already has its sockets.)
class NoDescriptors {
 public:
  NoDescriptors() {
    getrlimit(RLIMIT_NOFILE, &before_);
    rlimit none = before_;
    none.rlim_cur = 3;
    setrlimit(RLIMIT_NOFILE, &none);
  }
  ~NoDescriptors() { setrlimit(RLIMIT_NOFILE, &before_); }
  NoDescriptors(const NoDescriptors&) = delete;
  NoDescriptors& operator=(const NoDescriptors&) = delete;

 private:
  rlimit before_{};
};

TEST_F(DoorbellLoss, ForWantOfDescriptorsIsServedByUdpUntilThereAreSome) {
  const Listening first, second;
  Talking talking(options());
  first.begin();
  ASSERT_TRUE(talking.is_heard(TransportKind::shm));
  {
    const NoDescriptors limit;
    second.begin();
    ASSERT_TRUE(eventually([&] {
      return std::ranges::any_of(talking.readers(), [](const PublisherStatus::Reader& reader) {
        return reader.served && reader.transport == TransportKind::udp &&
               reader.reason.find("Too many open files") != std::string::npos;
      });
    }));
    // A datagram of this sample wakes the second listener. When it is awake, it may find the sample in
    // shared memory.
    EXPECT_TRUE(talking.is_heard_by(2));
    EXPECT_TRUE(eventually([&] { return warned_of("Too many open files") == 1; }));
  }
  EXPECT_TRUE(talking.is_heard(TransportKind::shm, 2));
  EXPECT_EQ(warned_of("Too many open files"), 1U) << "the warning comes once";
}

TEST_F(DoorbellLoss, OfNamesThatWereRemovedCostsRunningPairsAndNewcomersNothing) {
  const Listening running;
  Talking talking(options());
  running.begin();
  ASSERT_TRUE(talking.is_heard(TransportKind::shm));
  for (const auto& entry : std::filesystem::directory_iterator("/dev/shm")) {
    if (entry.path().filename().string().starts_with("sft_bell_")) std::filesystem::remove(entry.path());
  }
  EXPECT_TRUE(talking.is_heard(TransportKind::shm)) << "what is mapped stays";
  Talking newcomer(options());
  ASSERT_TRUE(newcomer.shm_is_ready());
  EXPECT_TRUE(newcomer.is_heard(TransportKind::shm)) << "the listener's process still has its page";
  EXPECT_EQ(warned_of("/dev/shm/sft_bell_"), 0U);
}

/// A service manager at log-out or a clean-up script may remove all files in /dev/shm.
TEST_F(DoorbellLoss, TogetherWithAllOfSharedMemoryIsOverInAMoment) {
  const Listening running;
  Talking talking(options());
  running.begin();
  ASSERT_TRUE(talking.is_heard(TransportKind::shm));
  for (const auto& entry : std::filesystem::directory_iterator("/dev/shm"))
    std::filesystem::remove_all(entry.path());
  Talking newcomer(options());
  EXPECT_TRUE(newcomer.is_heard(TransportKind::shm));
  EXPECT_TRUE(talking.is_heard(TransportKind::shm));
}

}  // namespace
}  // namespace sft::test
