// The fixture for tests with programs of several users on one host: the users' groups, and daemons of these
// users.
#pragma once

#include <signal.h>
#include <sys/mount.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "core/platform/text_of.h"
#include "tests/transports/shm/shm_fixture.h"

namespace sft::test {

constexpr gid_t writers_group = 70'100;
constexpr gid_t readers_group = 70'101;
// Only the processes of these users have the groups. No file lists the users as members.
inline const Identity a_writer{70'001, 70'001, {writers_group}};
inline const Identity a_reader{70'002, 70'002, {readers_group}};
inline const Identity another_account{70'003, 70'003, {}};
inline const Identity nobody{65'534, 65'534, {}};

/// Mounts another /run for the test. In it the directory /run/sft belongs to the user.
class RunDirectory {
 public:
  explicit RunDirectory(uid_t user) {
    EXPECT_EQ(mount("tmpfs", "/run", "tmpfs", 0, "mode=755"), 0);
    std::filesystem::create_directory("/run/sft");
    EXPECT_EQ(chown("/run/sft", user, 0), 0);
  }
  ~RunDirectory() { umount2("/run", MNT_DETACH); }
  RunDirectory(const RunDirectory&) = delete;
  RunDirectory& operator=(const RunDirectory&) = delete;
};

/// A daemon that the test ends in an orderly way, as a service manager does. So the daemon leaves no files
/// that would disturb another user's daemon.
class RunningSftd : public Process {
 public:
  using Process::Process;
  RunningSftd(RunningSftd&&) = default;
  ~RunningSftd() {
    signal(SIGTERM);
    exit_code();
  }
};

/// Returns true if the test can start processes of other users. In a user namespace of its own a test cannot
/// do that.
inline bool other_users_exist() {
  if (geteuid() != 0) return false;
  unsigned first = 0;
  unsigned outside = 0;
  unsigned long count = 0;
  return std::sscanf(core::text_of("/proc/self/uid_map").c_str(), "%u %u %lu", &first, &outside, &count) ==
             3 &&
         count > another_account.user;
}

/// A test with its own /etc/group, which has the groups. The programs are in a directory where every user may
/// run them.
class AccountsTest : public ShmTest {
 protected:
  void SetUp() override {
    ShmTest::SetUp();
    if (IsSkipped()) return;
    if (!other_users_exist()) GTEST_SKIP() << "needs root, to start processes of other users";
    std::ofstream("/tmp/group") << core::text_of("/etc/group") << "sft_writers:x:" << writers_group
                                << ":root\n"
                                << "sft_readers:x:" << readers_group << ":\n";
    ASSERT_EQ(mount("/tmp/group", "/etc/group", nullptr, MS_BIND, nullptr), 0);
    std::ofstream("/tmp/sftd.toml") << "total_mib = 16\nlog_level = 'error'\n"
                                       "[access]\nwriters = 'sft_writers'\nreaders = 'sft_readers'\n";
    std::filesystem::create_directory(programs_);
    for (const char* program : {"sftd", "shm_peer"})
      std::filesystem::copy(program_directory() + "/" + program, programs_ + program);
  }
  void TearDown() override {
    umount2("/etc/group", MNT_DETACH);
    std::filesystem::remove_all(programs_);
    ShmTest::TearDown();
  }

  RunningSftd start_sftd(std::vector<std::string> options, const Identity* as = nullptr) const {
    options.insert(options.begin(), {programs_ + "sftd", "--foreground"});
    RunningSftd daemon(options, as);
    EXPECT_EQ(daemon.line(), "sftd: ready");
    return daemon;
  }
  RunningSftd start_sftd_with_groups(const Identity* as = nullptr) const {
    return start_sftd({"--config=/tmp/sftd.toml"}, as);
  }
  Process start(const Identity& as, std::vector<std::string> task) const {
    task.insert(task.begin(), programs_ + "shm_peer");
    return Process(task, &as);
  }

  const std::string programs_ = "/tmp/programs/";
};

}  // namespace sft::test
