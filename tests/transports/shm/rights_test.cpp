// The rights of programs of several users. Writers may write samples, and readers may only read them. Other
// programs get an error that says so.
#include "shm_transport/sftd/exit_code.h"
#include "tests/transports/shm/accounts.h"

namespace sft::test {
namespace {

using shm::ExitCode;

class Rights : public AccountsTest {};

TEST_F(Rights, AReaderReadsSamplesThatAWriterOfAnotherUserPublishes) {
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

TEST_F(Rights, AReaderCannotOpenTheMemoryOfSamplesForWriting) {
  const RunningSftd daemon = start_sftd_with_groups();
  const std::vector<std::string> open_it{"/bin/sh", "-c", "exec 3<>/dev/shm/sft_writers; echo opened"};
  EXPECT_TRUE(contains(Process(open_it, &a_reader).all_output(), "Permission denied"));
  EXPECT_EQ(Process(open_it, &a_writer).all_output(), "opened\n");
}

TEST_F(Rights, AReaderIsToldThatItMayNotPublish) {
  const RunningSftd daemon = start_sftd_with_groups();
  const std::string said = start(a_reader, {"offer", "1"}).line();
  EXPECT_TRUE(contains(said, "read samples in shared memory but not write them")) << said;
  EXPECT_TRUE(contains(said, "group sft_writers")) << said;
  EXPECT_EQ(start(a_writer, {"offer", "1"}).line(), "may publish");
}

TEST_F(Rights, AReadersDoorbellIsRungByAWriterOfAnotherUser) {
  const RunningSftd daemon = start_sftd_with_groups();
  Process reader = start(a_reader, {"listen"});
  const std::string page = reader.line();
  EXPECT_EQ(start(a_writer, {"ring", page}).line(), "rang");
}

TEST_F(Rights, AStrangerIsToldAtOnceThatPermissionIsDenied) {
  const RunningSftd daemon = start_sftd_with_groups();
  const std::string said = start(another_account, {"knock"}).line();
  EXPECT_TRUE(contains(said, "permission denied")) << said;
  // This user has no name in the system.
  EXPECT_TRUE(contains(said, "sftd serves the members of group sft_writers; give this program that group"))
      << said;
}

TEST_F(Rights, AUserWhoIsNoMemberIsToldTheGroupAndTheCommand) {
  const RunningSftd daemon = start_sftd_with_groups();
  const std::string said = start(nobody, {"knock"}).line();
  EXPECT_TRUE(contains(said, "run: sudo adduser nobody sft_writers, log out and in again")) << said;
}

TEST_F(Rights, AStrangerMayNotOpenTheMemory) {
  const RunningSftd daemon = start_sftd_with_groups();
  for (const std::string name : {"sft_writers", "iceoryx_mgmt"}) {
    Process look({"/bin/cat", "/dev/shm/" + name}, &another_account);
    EXPECT_TRUE(contains(look.line(), "Permission denied"));
  }
}

TEST_F(Rights, ADaemonWithoutGroupsInItsConfigurationServesItsOwnGroup) {
  const RunningSftd daemon = start_sftd({"--pool-mib=16", "--log-level=error"});
  const Identity member{70'001, 70'001, {getegid()}};
  Process writer = start(member, {"publish", "1", "100"});
  ASSERT_EQ(writer.line(), "publishing");
  const Identity other_member{70'002, 70'002, {getegid()}};
  EXPECT_EQ(start(other_member, {"try-to-write", "1"}).line(), "reads 100");
  EXPECT_TRUE(contains(start(another_account, {"knock"}).line(), "permission denied"));
}

TEST_F(Rights, ADaemonThatIsNotRootServesOtherUsers) {
  const Identity daemon_user{70'010, writers_group, {readers_group}};
  // programs of other users accept a daemon if /run/sft belongs to the daemon's user
  const RunDirectory of_the_daemon(daemon_user.user);
  const RunningSftd daemon = start_sftd_with_groups(&daemon_user);
  Process writer = start(a_writer, {"publish", "1", "100"});
  ASSERT_EQ(writer.line(), "publishing");
  EXPECT_EQ(start(a_reader, {"try-to-write", "1"}).line(), "reads 100");
}

TEST_F(Rights, ADaemonThatMayNotServeTheGroupSaysSo) {
  Process daemon({programs_ + "sftd", "--config=/tmp/sftd.toml", "--foreground"}, &another_account);
  EXPECT_TRUE(contains(daemon.line(), "may not run as group sft_writers"));
  EXPECT_EQ(daemon.exit_code(), static_cast<int>(ExitCode::failed));
}

TEST_F(Rights, AGroupThatDoesNotExistIsNamed) {
  std::ofstream("/tmp/sftd.toml") << "[access]\nwriters = 'nobody_has_it'\n";
  Process daemon({programs_ + "sftd", "--config=/tmp/sftd.toml", "--foreground"});
  EXPECT_TRUE(contains(daemon.line(), "nobody_has_it"));
  EXPECT_EQ(daemon.exit_code(), static_cast<int>(ExitCode::bad_config));
}

TEST_F(Rights, AGroupWithoutMembersIsNamedWithTheCommandThatAddsOne) {
  std::ofstream("/tmp/group", std::ios::app) << "sft_empty:x:70102:\n";
  std::ofstream("/tmp/sftd.toml") << "[access]\nwriters = 'sft_empty'\n";
  Process daemon({programs_ + "sftd", "--config=/tmp/sftd.toml", "--foreground"});
  const std::string said = daemon.line();
  EXPECT_TRUE(contains(said, "sudo adduser root sft_empty")) << said;
  EXPECT_EQ(daemon.exit_code(), static_cast<int>(ExitCode::failed));
}

TEST_F(Rights, EverybodyMaySeeTheStatusAndOnlyTheDaemonsUserMayStopIt) {
  const RunningSftd daemon = start_sftd_with_groups();
  Process status({programs_ + "sftd", "status"}, &another_account);
  EXPECT_TRUE(contains(status.all_output(), "sft_readers only subscribes"));
  EXPECT_EQ(status.exit_code(), static_cast<int>(ExitCode::done));
  Process stop({programs_ + "sftd", "stop"}, &a_writer);
  EXPECT_TRUE(contains(stop.all_output(), "of user root"));
  EXPECT_EQ(stop.exit_code(), static_cast<int>(ExitCode::not_permitted));
  EXPECT_TRUE(is_alive(daemon.pid()));
}

}  // namespace
}  // namespace sft::test
