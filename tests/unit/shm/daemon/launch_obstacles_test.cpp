// The obstacles to a start of sftd: the circumstances that count as an obstacle, and the changes after which
// another attempt is made.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "shm_transport/daemon/launch_obstacles.h"

namespace sft::shm {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t MiB = std::uint64_t{1} << 20;

class LaunchObstaclesTest : public ::testing::Test {
 protected:
  ~LaunchObstaclesTest() override { fs::remove_all(directory_); }

  const std::string& directory() const { return directory_; }
  std::string path(const std::string& name) const { return directory_ + "/" + name; }
  void make_file(const std::string& name) const { std::ofstream(path(name)) << "text"; }
  void make_fifo(const std::string& name) const { ASSERT_EQ(mkfifo(path(name).c_str(), 0600), 0); }
  /// Returns the present obstacles without the free space, which other programs change.
  LaunchObstacles look() const {
    LaunchObstacles found =
        LaunchObstacles::look({path("a"), path("b")}, directory_.c_str(), directory_.c_str());
    found.shm = found.tmp = {};
    return found;
  }

 private:
  const std::string directory_ = [] {
    std::string name = fs::temp_directory_path() / "sft_obstacles_XXXXXX";
    return std::string(mkdtemp(name.data()));
  }();
};

TEST_F(LaunchObstaclesTest, FreeSpaceIsThatOfEachDirectory) {
  const char* const without_space = "/proc";
  const LaunchObstacles in_shm = LaunchObstacles::look({}, directory().c_str(), without_space);
  EXPECT_GT(in_shm.shm.bytes, 0U);
  EXPECT_EQ(in_shm.tmp, LaunchObstacles::Space());
  const LaunchObstacles in_tmp = LaunchObstacles::look({}, without_space, directory().c_str());
  EXPECT_EQ(in_tmp.shm, LaunchObstacles::Space());
  EXPECT_GT(in_tmp.tmp.bytes, 0U);
}

TEST_F(LaunchObstaclesTest, ThereAreNoObstaclesIfTheNamesAreFree) {
  const LaunchObstacles found = look();
  EXPECT_TRUE(found.files.empty());
  EXPECT_FALSE(found.have_eased_since(found));
}

// Each attempt itself creates and removes ordinary files of this account.
TEST_F(LaunchObstaclesTest, OrdinaryFilesOfThisAccountAreNoObstacles) {
  make_file("a");
  EXPECT_TRUE(look().files.empty());
}

TEST_F(LaunchObstaclesTest, FilesOfOtherAccountsAreObstacles) {
  if (geteuid() != 0) GTEST_SKIP() << "needs root, to give a file away";
  make_file("a");
  ASSERT_EQ(chown(path("a").c_str(), 65534, 65534), 0);
  ASSERT_EQ(look().files.size(), 1U);
  EXPECT_EQ(look().files[0].owner, 65534U);
  EXPECT_EQ(look().files[0].path, path("a"));
}

TEST_F(LaunchObstaclesTest, LinksAreObstaclesAlsoIfTheyLeadNowhere) {
  fs::create_symlink("/tmp/nowhere", path("a"));
  fs::create_symlink(path("a"), path("b"));
  EXPECT_EQ(look().files.size(), 2U);
}

TEST_F(LaunchObstaclesTest, ObstaclesHaveNotEasedWhileEachOfThemIsStillThere) {
  make_fifo("a");
  const LaunchObstacles before = look();
  EXPECT_FALSE(look().have_eased_since(before));
  make_fifo("b");
  EXPECT_FALSE(look().have_eased_since(before)) << "a second obstacle came";
}

TEST_F(LaunchObstaclesTest, ObstaclesHaveEasedWhenOneOfThemIsGone) {
  make_fifo("a");
  make_fifo("b");
  const LaunchObstacles before = look();
  fs::remove(path("b"));
  EXPECT_TRUE(look().have_eased_since(before));
}

TEST_F(LaunchObstaclesTest, ObstaclesHaveEasedWhenOneOfThemWasReplaced) {
  make_fifo("a");
  const LaunchObstacles before = look();
  make_fifo("b");
  fs::rename(path("b"), path("a"));
  EXPECT_TRUE(look().have_eased_since(before)) << "another FIFO has replaced it";
  fs::remove(path("a"));
  make_file("a");
  EXPECT_TRUE(look().have_eased_since(before)) << "an ordinary file of this account has replaced it";
}

TEST_F(LaunchObstaclesTest, ObstaclesThatCameDuringTheAttemptCountToo) {
  LaunchObstacles before = look();
  make_fifo("a");
  before.add(look());
  before.add(look());
  EXPECT_EQ(before.files.size(), 1U);
  fs::remove(path("a"));
  EXPECT_TRUE(look().have_eased_since(before));
}

TEST_F(LaunchObstaclesTest, ObstaclesEaseWithConsiderablyMoreSpaceAndNotWithALittleMore) {
  const auto eases = [](std::uint64_t before, std::uint64_t after) {
    return LaunchObstacles{.shm{.bytes = after}}.have_eased_since({.shm{.bytes = before}});
  };
  EXPECT_FALSE(eases(0, 16 * MiB - 1));
  EXPECT_TRUE(eases(0, 16 * MiB));
  EXPECT_FALSE(eases(800 * MiB, 900 * MiB - 1));
  EXPECT_TRUE(eases(800 * MiB, 900 * MiB));
  EXPECT_FALSE(eases(800 * MiB, 0));
}

TEST_F(LaunchObstaclesTest, ObstaclesEaseWithMoreSpaceForLocksAndSockets) {
  const auto eases = [](std::uint64_t before, std::uint64_t after) {
    return LaunchObstacles{.tmp{.bytes = after}}.have_eased_since({.tmp{.bytes = before}});
  };
  EXPECT_FALSE(eases(0, 1 * MiB - 1));
  EXPECT_TRUE(eases(0, 1 * MiB));
  EXPECT_FALSE(eases(800 * MiB, 900 * MiB - 1));
}

TEST_F(LaunchObstaclesTest, ObstaclesEaseWhenMoreFilesCanBeMade) {
  EXPECT_FALSE((LaunchObstacles{.shm{.files = 15}}.have_eased_since({})));
  EXPECT_TRUE((LaunchObstacles{.shm{.files = 16}}.have_eased_since({})));
  EXPECT_TRUE((LaunchObstacles{.tmp{.files = 16}}.have_eased_since({})));
  EXPECT_FALSE((LaunchObstacles{.tmp{.files = 899}}.have_eased_since({.tmp{.files = 800}})));
}

// Other programs may fill /tmp during the attempt. In /dev/shm the attempt itself takes space.
TEST_F(LaunchObstaclesTest, SpaceThatWasTakenDuringTheAttemptCountsInTmpOnly) {
  LaunchObstacles before{.shm{.bytes = 100 * MiB}, .tmp{.bytes = 100 * MiB}};
  before.add({.shm{.bytes = 0}, .tmp{.bytes = 0}});
  EXPECT_EQ(before.shm.bytes, 100 * MiB);
  EXPECT_EQ(before.tmp.bytes, 0U);
  EXPECT_TRUE((LaunchObstacles{.shm{.bytes = 100 * MiB}, .tmp{.bytes = 100 * MiB}}.have_eased_since(before)));
}

TEST_F(LaunchObstaclesTest, AllNamesThatTheFirstAttemptNeedsAreLookedAt) {
  const std::vector<std::string> all = daemon_files("the_group");
  EXPECT_EQ(all.back(), "/dev/shm/the_group");
  const std::vector<std::string> own = files_of_own_daemon();
  ASSERT_GE(own.size() + 1, all.size());
  EXPECT_TRUE(std::equal(all.begin(), all.end() - 1, own.begin()));
}

}  // namespace
}  // namespace sft::shm
