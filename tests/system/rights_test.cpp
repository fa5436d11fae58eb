// Nodes of several users on one host.
#include <grp.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/mount.h>
#include <sys/wait.h>
#include <unistd.h>

#include <sft/sft.h>
#include <cstdio>
#include <fstream>
#include <sensor_msgs/msg/PointCloud2.hpp>

#include "core/platform/text_of.h"
#include "tests/support/eventually.h"
#include "tests/support/isolated_host.h"

namespace sft::test {
namespace {

using sensor_msgs::msg::PointCloud2;
using F = PointCloud2::Field;
using namespace std::chrono_literals;

constexpr gid_t writers_group = 70'100;
constexpr gid_t readers_group = 70'101;
constexpr uid_t reader = 70'002;

bool other_users_exist() {
  unsigned first = 0;
  unsigned outside = 0;
  unsigned long count = 0;
  return geteuid() == 0 &&
         std::sscanf(core::text_of("/proc/self/uid_map").c_str(), "%u %u %lu", &first, &outside, &count) ==
             3 &&
         count > reader;
}

/// Answers each sample that arrives by shared memory. Runs as a user that may only read shared memory.
[[noreturn]] void answer_what_comes_through_shared_memory() {
  if (setgroups(1, &readers_group) != 0 || setgid(reader) != 0 || setuid(reader) != 0) _exit(1);
  Node node = Node::open({.name = "reader"}).value();
  auto answers = node.publisher<PointCloud2>("answers").value();
  auto points = node.subscriber<PointCloud2, F::height>("points").value();
  for (;;) {
    points.wait(1s);
    while (const auto sample = points.take()) {
      if (sample.info().transport == TransportKind::shm)
        answers.publish(PointCloud2{.height = sample->height()});
    }
  }
}

/// A child process, which the destructor ends.
class Child {
 public:
  explicit Child(pid_t pid) : pid_(pid) {}
  ~Child() {
    kill(pid_, SIGTERM);
    waitpid(pid_, nullptr, 0);
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

 private:
  pid_t pid_;
};

pid_t start_sftd() {
  std::ofstream("/tmp/group") << core::text_of("/etc/group") << "sft_writers:x:" << writers_group << ":root\n"
                              << "sft_readers:x:" << readers_group << ":\n";
  EXPECT_EQ(mount("/tmp/group", "/etc/group", nullptr, MS_BIND, nullptr), 0);
  std::ofstream("/tmp/sftd.toml") << "[access]\nwriters = 'sft_writers'\nreaders = 'sft_readers'\n";
  const std::string path = program_directory() + "/sftd";
  std::string words[] = {path, "--foreground", "--log-level=error", "--config=/tmp/sftd.toml"};
  char* arguments[] = {words[0].data(), words[1].data(), words[2].data(), words[3].data(), nullptr};
  pid_t pid = -1;
  EXPECT_EQ(posix_spawn(&pid, path.c_str(), nullptr, nullptr, arguments, environ), 0);
  EXPECT_TRUE(eventually([] { return access("/dev/shm/sft_status", F_OK) == 0; }, 20s));
  return pid;
}

TEST(Rights, ANodeThatMayOnlyReadHearsBySharedMemoryAndPublishesByUdp) {
  if (!isolation_refusal().empty()) GTEST_SKIP() << isolation_refusal();
  if (!other_users_exist()) GTEST_SKIP() << "needs root, to start processes of other users";
  const Child daemon(start_sftd());
  const pid_t pid = fork();
  if (pid == 0) answer_what_comes_through_shared_memory();
  const Child other(pid);
  Node node = Node::open({.name = "writer"}).value();
  auto points = node.publisher<PointCloud2>("points").value();
  auto answers = node.subscriber<PointCloud2, F::height>("answers").value();
  const auto hears_an_answer = [&] {
    points.publish(PointCloud2{.height = 7});
    answers.wait(20ms);
    const auto answer = answers.take();
    return answer && answer.info().transport == TransportKind::udp && answer->height() == 7U;
  };
  EXPECT_TRUE(eventually(hears_an_answer, 30s));
  const auto writers = answers.status().writers;
  ASSERT_EQ(writers.size(), 1U);
  EXPECT_EQ(writers[0].transport, TransportKind::udp);
}

}  // namespace
}  // namespace sft::test
