// Programs of several users: who may write samples, who may only read them, and who is told that it may
// neither.
#include <signal.h>
#include <sys/mount.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "shm_fixture.h"
#include "shm_transport/sftd/exit_code.h"

namespace sft::test {
namespace {

namespace fs = std::filesystem;
using shm::ExitCode;

constexpr gid_t writers_group = 70'100;
constexpr gid_t readers_group = 70'101;
// Members of these groups only by what their process was given: no file knows them.
const Identity a_writer{70'001, 70'001, {writers_group}};
const Identity a_reader{70'002, 70'002, {readers_group}};
const Identity a_stranger{70'003, 70'003, {}};

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

std::string text_of(const fs::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// Ended as a service manager would: what it made may be in the way of another user's.
class RunningSftd : public Process {
 public:
  using Process::Process;
  RunningSftd(RunningSftd&&) = default;
  ~RunningSftd() {
    signal(SIGTERM);
    exit_code();
  }
};

/// Whether processes here can be those of other users: not so in a user namespace of one's own.
bool other_users_exist() {
  if (geteuid() != 0) return false;
  unsigned first = 0;
  unsigned outside = 0;
  unsigned long count = 0;
  return std::sscanf(text_of("/proc/self/uid_map").c_str(), "%u %u %lu", &first, &outside, &count) == 3 &&
         count > a_stranger.user;
}

/// The groups, in this host's own /etc/group, and the programs where everybody may run them.
class Rights : public ShmTest {
 protected:
  void SetUp() override {
    ShmTest::SetUp();
    if (IsSkipped()) return;
    if (!other_users_exist()) GTEST_SKIP() << "needs root, to start processes of other users";
    std::ofstream("/tmp/group") << text_of("/etc/group") << "sft_writers:x:" << writers_group << ":root\n"
                                << "sft_readers:x:" << readers_group << ":\n";
    ASSERT_EQ(mount("/tmp/group", "/etc/group", nullptr, MS_BIND, nullptr), 0);
    std::ofstream("/tmp/sftd.toml") << "total_mib = 16\nlog_level = 'error'\n"
                                       "[access]\nwriters = 'sft_writers'\nreaders = 'sft_readers'\n";
    fs::create_directory(programs_);
    for (const char* program : {"sftd", "shm_peer"})
      fs::copy(program_directory() + "/" + program, programs_ + program);
  }
  void TearDown() override {
    umount2("/etc/group", MNT_DETACH);
    fs::remove_all(programs_);
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

TEST_F(Rights, ReadersOfOtherUsersReadWhatWritersOfOtherUsersPublish) {
  const RunningSftd daemon = start_sftd_with_groups();
  Process writer = start(a_writer, {"publish", "1", "100"});
  ASSERT_EQ(writer.line(), "publishing");
  EXPECT_EQ(start(a_reader, {"try-to-write", "1"}).line(), "reads 100");
}

TEST_F(Rights, AReaderCannotWriteTheSampleThatItReads) {
  const RunningSftd daemon = start_sftd_with_groups();
  Process writer = start(a_writer, {"publish", "1", "100"});
  ASSERT_EQ(writer.line(), "publishing");
  Process reader = start(a_reader, {"try-to-write", "1"});
  EXPECT_EQ(reader.line(), "reads 100");
  EXPECT_EQ(reader.line(), "cannot write");
}

TEST_F(Rights, AReaderCannotOpenTheMemoryOfSamplesForWritingEither) {
  const RunningSftd daemon = start_sftd_with_groups();
  const std::vector<std::string> open_it{"/bin/sh", "-c", "exec 3<>/dev/shm/sft_writers; echo opened"};
  EXPECT_TRUE(contains(Process(open_it, &a_reader).all_output(), "Permission denied"));
  EXPECT_EQ(Process(open_it, &a_writer).all_output(), "opened\n");
}

TEST_F(Rights, AReaderIsToldThatItMayNotPublish) {
  const RunningSftd daemon = start_sftd_with_groups();
  EXPECT_TRUE(
      contains(start(a_reader, {"offer", "1"}).line(), "read samples in shared memory but not write them"));
  EXPECT_EQ(start(a_writer, {"offer", "1"}).line(), "may publish");
}

TEST_F(Rights, AReadersDoorbellIsRungByAWriterOfAnotherUser) {
  const RunningSftd daemon = start_sftd_with_groups();
  Process reader = start(a_reader, {"listen"});
  const std::string page = reader.line();
  EXPECT_EQ(start(a_writer, {"ring", page}).line(), "rang");
}

TEST_F(Rights, AStrangerIsToldSoAtOnce) {
  const RunningSftd daemon = start_sftd_with_groups();
  EXPECT_TRUE(contains(start(a_stranger, {"knock"}).line(), "permission denied"));
}

TEST_F(Rights, AStrangerMayNotOpenTheMemory) {
  const RunningSftd daemon = start_sftd_with_groups();
  for (const std::string name : {"sft_writers", "iceoryx_mgmt"}) {
    Process look({"/bin/cat", "/dev/shm/" + name}, &a_stranger);
    EXPECT_TRUE(contains(look.line(), "Permission denied"));
  }
}

TEST_F(Rights, WithoutGroupsInItsConfigurationItServesItsOwn) {
  const RunningSftd daemon = start_sftd({"--pool-mib=16", "--log-level=error"});
  const Identity member{70'001, 70'001, {getegid()}};
  Process writer = start(member, {"publish", "1", "100"});
  ASSERT_EQ(writer.line(), "publishing");
  const Identity other_member{70'002, 70'002, {getegid()}};
  EXPECT_EQ(start(other_member, {"try-to-write", "1"}).line(), "reads 100");
  EXPECT_TRUE(contains(start(a_stranger, {"knock"}).line(), "permission denied"));
}

TEST_F(Rights, ADaemonThatIsNotRootServesOtherUsersToo) {
  const Identity daemon_user{70'010, writers_group, {readers_group}};
  const RunningSftd daemon = start_sftd_with_groups(&daemon_user);
  Process writer = start(a_writer, {"publish", "1", "100"});
  ASSERT_EQ(writer.line(), "publishing");
  EXPECT_EQ(start(a_reader, {"try-to-write", "1"}).line(), "reads 100");
}

TEST_F(Rights, ADaemonThatMayNotServeTheGroupSaysSo) {
  Process daemon({programs_ + "sftd", "--config=/tmp/sftd.toml", "--foreground"}, &a_stranger);
  EXPECT_TRUE(contains(daemon.line(), "may not run as group sft_writers"));
  EXPECT_EQ(daemon.exit_code(), static_cast<int>(ExitCode::failed));
}

TEST_F(Rights, AGroupThatDoesNotExistIsNamed) {
  std::ofstream("/tmp/sftd.toml") << "[access]\nwriters = 'nobody_has_it'\n";
  Process daemon({programs_ + "sftd", "--config=/tmp/sftd.toml", "--foreground"});
  EXPECT_TRUE(contains(daemon.line(), "nobody_has_it"));
  EXPECT_EQ(daemon.exit_code(), static_cast<int>(ExitCode::bad_config));
}

TEST_F(Rights, EverybodyMaySeeTheStatusAndOnlyItsUserMayStopIt) {
  const RunningSftd daemon = start_sftd_with_groups();
  Process status({programs_ + "sftd", "status"}, &a_stranger);
  EXPECT_TRUE(contains(status.all_output(), "sft_readers only subscribes"));
  EXPECT_EQ(status.exit_code(), static_cast<int>(ExitCode::done));
  Process stop({programs_ + "sftd", "stop"}, &a_writer);
  EXPECT_TRUE(contains(stop.all_output(), "of user root"));
  EXPECT_EQ(stop.exit_code(), static_cast<int>(ExitCode::not_permitted));
  EXPECT_TRUE(is_alive(daemon.pid()));
}

}  // namespace
}  // namespace sft::test
