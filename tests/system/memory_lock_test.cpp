// A program that locks its memory, as real-time programs do, has no page fault on the path of samples. All
// memory that samples need is mapped once the nodes are open and have warmed up.
#include <sys/mman.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "tests/system/fixture.h"

namespace sft::test {
namespace {

/// The page faults of a thread of this process: minor faults need no access to a disk, major faults do.
struct Faults {
  std::string thread;
  std::uint64_t minor = 0;
  std::uint64_t major = 0;
};

std::map<int, Faults> faults() {
  std::map<int, Faults> faults;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/task")) {
    std::string line;
    std::getline(std::ifstream(entry.path() / "stat"), line);
    const std::size_t open = line.find('('), close = line.rfind(')');
    std::istringstream rest(line.substr(close + 2));
    std::string skipped;
    for (int i = 0; i < 7; ++i) rest >> skipped;  // skips the fields from `state` to `flags`
    Faults& of = faults[std::stoi(entry.path().filename())];
    of.thread = line.substr(open + 1, close - open - 1);
    rest >> of.minor >> skipped >> of.major;
  }
  return faults;
}

/// Returns the threads on the path of samples that have had page faults since `before`, with their counts, as
/// text.
std::string faulting_since(const std::map<int, Faults>& before) {
  std::string faulting;
  for (const auto& [number, now] : faults()) {
    const auto then = before.find(number);
    const bool on_the_path = number == getpid() || now.thread.starts_with("sft-udp") ||
                             now.thread.starts_with("sft-call") || now.thread.starts_with("sft-wake");
    if (!on_the_path || then == before.end()) continue;
    const std::uint64_t met = now.minor - then->second.minor + now.major - then->second.major;
    if (met > 0) faulting += now.thread + ": " + std::to_string(met) + " ";
  }
  return faulting;
}

class MemoryLockTest : public PubSubTest {
 protected:
  void SetUp() override {
    if (mlockall(MCL_CURRENT | MCL_FUTURE) != 0)
      GTEST_SKIP() << "needs CAP_IPC_LOCK or another limit RLIMIT_MEMLOCK: " << std::strerror(errno);
  }
  void TearDown() override { munlockall(); }
};

TEST_P(MemoryLockTest, ThreadsThatPublishSendReceiveAndCallBackMeetNoPageFault) {
  Node a = open("a");
  Node b = open("b");
  auto publisher = a.publisher<PointCloud2>("points").value();
  auto taken = b.subscriber<PointCloud2, F::height | F::data>("points").value();
  std::atomic<std::uint64_t> called{0};
  auto called_back = b.subscriber<PointCloud2, F::width | F::fields>("points", [&](const auto& sample) {
                        called += sample->width();
                      }).value();
  expect_served(publisher, 2);
  const PointCloud2 message = cloud(1, 100'000);
  std::uint64_t bytes = 0;
  const auto pass = [&] {
    publisher.publish(message);
    auto loan = publisher.loan(message, {.data = 100'000});
    loan->set(F::height, 3U);
    std::move(*loan).publish();
    while (taken.wait(2ms)) {
      while (const auto sample = taken.take()) bytes += sample->data().size();
    }
  };
  // Samples that are under way occupy memory. On a busy machine it may take a while until the number of
  // samples under way has reached its maximum for the first time.
  std::string faulting;
  EXPECT_TRUE(eventually(
      [&] {
        const auto before = faults();
        for (int i = 0; i < 300; ++i) pass();
        faulting = faulting_since(before);
        return faulting.empty();
      },
      60s))
      << faulting;
  EXPECT_GE(bytes, 300 * 90'000U);
  EXPECT_GE(called, 300U);
}

INSTANTIATE_TEST_SUITE_P(Ways, MemoryLockTest, ::testing::Values(Way::shm, Way::udp, Way::udp_sockets),
                         way_name);

}  // namespace
}  // namespace sft::test
