// The times at which a node tries again to start sftd. The tests set the time. The programs that the node
// starts here are not sftd, and end at once.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>

#include "tests/transports/shm/shm_fixture.h"

namespace sft::test {
namespace {

using core::Availability;

class LaunchTest : public ShmTest {
 protected:
  static shm::ShmOptions options(const char* program) {
    shm::ShmOptions options = own_daemon();
    options.daemon_path = program;
    return options;
  }
  /// Returns options with a program that ends with an error, because the program does not accept the options
  /// of sftd.
  static shm::ShmOptions refusing() { return options("/bin/cat"); }
  static bool fails(Node& node, Clock::time_point at) {
    return eventually([&] { return node->poll(at) == Availability::unavailable; });
  }
  static bool tries(Node& node, Clock::time_point at) { return node->poll(at) == Availability::starting; }

  const Clock::time_point begin_ = Clock::now();
};

TEST_F(LaunchTest, ANodeTriesEverMoreSeldomWhileNothingChanges) {
  Node node(refusing());
  Clock::time_point now = begin_;
  for (const auto pause : {500ms, 1000ms, 2000ms, 4000ms}) {
    ASSERT_TRUE(tries(node, now));
    ASSERT_TRUE(fails(node, now));
    EXPECT_FALSE(tries(node, now + pause - 1ms));
    now += pause;
  }
}

TEST_F(LaunchTest, ANodeTriesAtOnceWhenAFileInTheWayIsGone) {
  ASSERT_EQ(mkfifo("/tmp/roudi.lock", 0600), 0);
  Node node(refusing());
  Clock::time_point now = begin_;
  for (const auto pause : {500ms, 1000ms, 2000ms}) {
    ASSERT_TRUE(tries(node, now));
    ASSERT_TRUE(fails(node, now));
    now += pause;
  }
  ASSERT_TRUE(tries(node, now));
  ASSERT_TRUE(fails(node, now));
  EXPECT_FALSE(tries(node, now + 200ms)) << "the file is still in the way";
  std::filesystem::remove("/tmp/roudi.lock");
  EXPECT_TRUE(tries(node, now + 200ms));
}

TEST_F(LaunchTest, ANodeTriesAtMostOnceIn200MsHoweverOftenFilesAreMadeAndRemoved) {
  Node node(refusing());
  Clock::time_point now = begin_;
  for (int i = 0; i < 5; ++i) {
    ASSERT_EQ(mkfifo("/tmp/roudi.lock", 0600), 0);
    ASSERT_TRUE(tries(node, now));
    ASSERT_TRUE(fails(node, now));
    std::filesystem::remove("/tmp/roudi.lock");
    EXPECT_FALSE(tries(node, now + 199ms));
    now += 200ms;
  }
}

TEST_F(LaunchTest, PausesDoNotGrowIfTheDaemonStartsAndEndsAgain) {
  Node node(options("/bin/true"));
  Clock::time_point now = begin_;
  for (int i = 0; i < 5; ++i) {
    ASSERT_TRUE(tries(node, now));
    ASSERT_TRUE(fails(node, now));
    EXPECT_FALSE(tries(node, now + 499ms));
    now += 500ms;
  }
}

TEST_F(LaunchTest, ANodeTriesAtOnceWhenThereIsSpaceAgain) {
  const std::string full = "/dev/shm/full";
  const auto space = std::filesystem::space("/dev/shm");
  const int file = open(full.c_str(), O_CREAT | O_EXCL | O_RDWR | O_CLOEXEC, 0600);
  ASSERT_GE(file, 0);
  ASSERT_EQ(posix_fallocate(file, 0, static_cast<off_t>(space.available - space.available / 64)), 0);
  close(file);
  Node node;  // starts the real sftd
  ASSERT_TRUE(tries(node, begin_));
  ASSERT_TRUE(fails(node, begin_));
  EXPECT_NE(node->description().find("/dev/shm has"), std::string::npos) << node->description();
  EXPECT_FALSE(tries(node, begin_ + 200ms));
  std::filesystem::remove(full);
  EXPECT_TRUE(tries(node, begin_ + 200ms));
  EXPECT_TRUE(node.becomes_ready()) << node->description();
}

}  // namespace
}  // namespace sft::test
