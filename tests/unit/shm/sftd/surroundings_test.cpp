#include "shm_transport/sftd/surroundings.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "tests/support/temporary_directory.h"

namespace sft::shm {
namespace {

namespace fs = std::filesystem;

class SurroundingsTest : public ::testing::Test {
 protected:
  SurroundingsTest() {
    for (const std::string& one : {all_.proc + "/self", all_.shm, all_.tmp}) fs::create_directories(one);
    std::ofstream(all_.proc + "/self/stat") << "1";
  }

  sft::test::TemporaryDirectory directory_;
  const std::string root_ = directory_.path();
  const Surroundings all_{root_ + "/proc", root_ + "/shm", root_ + "/tmp"};
};

TEST_F(SurroundingsTest, LackNothingWhereAllIsThere) {
  EXPECT_EQ(all_.lacking(), "");
  EXPECT_EQ(Surroundings{}.lacking(), "") << "of this host";
}

TEST_F(SurroundingsTest, NameAProcThatIsNotMounted) {
  fs::remove_all(all_.proc + "/self");
  EXPECT_EQ(all_.lacking(), all_.proc + " is not mounted: mount it (mount -t proc proc " + all_.proc +
                                "), or start sftd where it is mounted");
}

TEST_F(SurroundingsTest, NameADirectoryThatIsNotThere) {
  fs::remove(all_.tmp);
  EXPECT_EQ(all_.lacking().find(all_.tmp + " is not there: mount a tmpfs there"), 0U) << all_.lacking();
  fs::remove(all_.shm);
  EXPECT_EQ(all_.lacking().find(all_.shm + " is not there: mount a tmpfs there"), 0U) << all_.lacking();
  std::ofstream(all_.shm) << "a file";
  EXPECT_EQ(all_.lacking().find(all_.shm + " is not there"), 0U) << all_.lacking();
}

/// Changes root's real account to an ordinary one while the object lives, since root may write everywhere.
/// access() checks the real account. Does nothing for other accounts.
class NotRoot {
 public:
  NotRoot() { change_to(65534); }
  ~NotRoot() { change_to(0); }
  NotRoot(const NotRoot&) = delete;
  NotRoot& operator=(const NotRoot&) = delete;

 private:
  static void change_to(uid_t account) {
    if (geteuid() != 0) return;
    EXPECT_EQ(setreuid(account, static_cast<uid_t>(-1)), 0);
  }
};

TEST_F(SurroundingsTest, NameADirectoryInWhichThisAccountMayNotWrite) {
  for (const std::string& one : {root_, all_.proc, all_.proc + "/self"})
    fs::permissions(one, fs::perms::owner_all | fs::perms(0055));
  for (const std::string& one : {all_.shm, all_.tmp}) fs::permissions(one, fs::perms::all);
  const auto lacking = [&] {
    const NotRoot account;
    return all_.lacking();
  };
  EXPECT_EQ(lacking(), "");
  fs::permissions(all_.tmp, fs::perms::owner_read);
  EXPECT_EQ(lacking(), "this account may not write to " + all_.tmp + ": chmod 1777 " + all_.tmp);
  fs::permissions(all_.tmp, fs::perms::owner_all);
}

}  // namespace
}  // namespace sft::shm
