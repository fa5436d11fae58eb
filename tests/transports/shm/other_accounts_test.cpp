// Hostile programs of other accounts, which have no special rights. They put files into /tmp and /dev/shm,
// take locks, and start daemons.
#include <fcntl.h>
#include <grp.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include <algorithm>
#include <functional>

#include "core/platform/doorbell.h"
#include "shm_transport/host/host_file.h"
#include "shm_transport/sftd/exit_code.h"
#include "tests/transports/shm/accounts.h"

namespace sft::test {
namespace {

namespace fs = std::filesystem;
using core::Availability;
using core::DoorbellPage;
using shm::ExitCode;

const Identity an_honest_user{70'001, writers_group, {}};

/// Runs an action under an account, in a process that the destructor ends.
class Action {
 public:
  Action(const Identity& as, const std::function<void()>& action) {
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0) std::abort();
    pid_ = fork();
    if (pid_ == 0) {
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      if (setgroups(0, nullptr) != 0 || setgid(as.group) != 0 || setuid(as.user) != 0) _exit(1);
      action();
      if (write(ends[1], "x", 1) != 1) _exit(1);
      for (;;) pause();
    }
    close(ends[1]);
    char done = 0;
    EXPECT_EQ(read(ends[0], &done, 1), 1) << "the action failed";
    close(ends[0]);
  }
  ~Action() {
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  Action(const Action&) = delete;
  Action& operator=(const Action&) = delete;

 private:
  pid_t pid_ = -1;
};

void shell(const Identity& as, const std::string& command) {
  Process process({"/bin/sh", "-c", command}, &as);
  const std::string output = process.all_output();
  EXPECT_EQ(process.exit_code(), 0) << command << ": " << output;
}

/// Locks the file for reading as soon as the file's write lock is released.
void wait_for_a_read_lock(const char* path) {
  const int file = open(path, O_RDONLY);
  struct flock lock {};
  lock.l_type = F_RDLCK;
  if (file < 0 || fcntl(file, F_OFD_SETLKW, &lock) != 0) _exit(1);
}

class OtherAccounts : public AccountsTest {
 protected:
  Process sftd_of(const Identity& user) const {
    return Process({programs_ + "sftd", "--foreground", "--log-level=error", "--pool-mib=16"}, &user);
  }
  /// Returns the reason why a program of this user cannot use shared memory. The program itself reports it.
  std::string reason_for(const Identity& user) const { return start(user, {"knock"}).line(); }
};

bool maps_a_segment() { return contains(core::text_of("/proc/self/maps"), "/dev/shm/"); }

TEST_F(OtherAccounts, PutAFifoInThePlaceOfTheHostFileAndNobodyHangs) {
  shell(nobody, std::string("mkfifo -m 666 ") + shm::host_file_path);
  const std::string reason = reason_for(an_honest_user);
  EXPECT_TRUE(contains(reason, shm::host_file_path)) << reason;
  EXPECT_TRUE(contains(reason, "user nobody")) << reason;
  Process status({programs_ + "sftd", "status"}, &an_honest_user);
  EXPECT_EQ(status.exit_code(), static_cast<int>(ExitCode::not_running));
  Node node;  // root's sftd removes the FIFO
  EXPECT_TRUE(node.becomes_ready()) << node->description();
}

TEST_F(OtherAccounts, PutAFifoInThePlaceOfTheDaemonsLockAndNobodyHangs) {
  shell(nobody, std::string("mkfifo -m 666 ") + shm::daemon_lock_path);
  EXPECT_TRUE(contains(reason_for(an_honest_user), shm::daemon_lock_path));
  Node node;
  EXPECT_TRUE(node.becomes_ready()) << node->description();
}

TEST_F(OtherAccounts, StartADaemonFirstAndNoProgramOfAnotherAccountUsesItsMemory) {
  RunningSftd theirs = start_sftd({"--pool-mib=16", "--log-level=error"}, &nobody);
  shell(nobody, "chmod 666 /dev/shm/iceoryx_mgmt /dev/shm/nogroup; chmod 777 /tmp/roudi");
  EXPECT_TRUE(contains(reason_for(an_honest_user), "the sftd of user nobody is not accepted"));
  EXPECT_EQ(start(nobody, {"knock"}).line(), "not refused") << "programs of the daemon's own account use it";
  Node node;
  ASSERT_TRUE(node.becomes(Availability::unavailable));
  EXPECT_TRUE(contains(node->description(), "the sftd of user nobody is not accepted"))
      << node->description();
  EXPECT_FALSE(maps_a_segment());
  Process mine({programs_ + "sftd", "--foreground"}, &an_honest_user);
  const std::string refusal = mine.all_output();
  EXPECT_TRUE(contains(refusal, "an sftd of user nobody (pid " + std::to_string(theirs.pid()) + ")"))
      << refusal;
  EXPECT_EQ(mine.exit_code(), static_cast<int>(ExitCode::failed));
  theirs.signal(SIGTERM);
  EXPECT_TRUE(node.becomes_ready()) << node->description();
}

TEST_F(OtherAccounts, ServeProgramsThatNameThem) {
  const RunningSftd theirs = start_sftd({"--pool-mib=16", "--log-level=error"}, &nobody);
  for (const char* name : {"nobody", "65534"}) {
    shm::ShmOptions options = no_daemon();
    options.daemon_users = {name};
    Node node(options);
    EXPECT_TRUE(node.becomes_ready()) << name << ": " << node->description();
  }
  const RunDirectory of_the_daemon(nobody.user);
  Node node(no_daemon());
  EXPECT_TRUE(node.becomes_ready()) << node->description();
}

TEST_F(OtherAccounts, ThatAreNamedHaveToExist) {
  shm::ShmOptions options = no_daemon();
  options.daemon_users = {"nobody_has_this_name"};
  const auto transport = shm::open_shm_transport(options);
  ASSERT_FALSE(transport);
  EXPECT_EQ(transport.error().code, Errc::invalid_argument);
  EXPECT_TRUE(contains(transport.error().message, "nobody_has_this_name")) << transport.error().message;
}

TEST_F(OtherAccounts, OwnNoSegmentThatIsMapped) {
  const RunningSftd daemon = start_sftd({"--pool-mib=16", "--log-level=error"});
  for (const std::string segment : {"/dev/shm/iceoryx_mgmt", "/dev/shm/root"}) {
    ASSERT_EQ(chown(segment.c_str(), nobody.user, 0), 0) << segment;
    Node node(no_daemon());
    ASSERT_TRUE(node.becomes(Availability::unavailable)) << segment;
    EXPECT_TRUE(contains(node->description(), segment + ": it belongs to user nobody"))
        << node->description();
    EXPECT_FALSE(maps_a_segment()) << segment;
    ASSERT_EQ(chown(segment.c_str(), 0, 0), 0);
  }
}

TEST_F(OtherAccounts, OwnNoSocketThatProgramsConnectTo) {
  const RunningSftd daemon = start_sftd({"--pool-mib=16", "--log-level=error"});
  ASSERT_EQ(chown(shm::roudi_socket_path, nobody.user, 0), 0);
  Node node(no_daemon());
  ASSERT_TRUE(node.becomes(Availability::unavailable));
  EXPECT_TRUE(contains(node->description(), "it belongs to user nobody")) << node->description();
}

TEST_F(OtherAccounts, KeepNoDeadDaemonAliveByALockForReading) {
  Node node(no_daemon());
  for (const int end : {SIGKILL, SIGTERM}) {
    Process daemon({sftd_path(), "--foreground", "--log-level=error", "--pool-mib=16"});
    ASSERT_EQ(daemon.line(), "sftd: ready");
    ASSERT_TRUE(node.becomes_ready()) << node->description();
    std::vector<std::unique_ptr<Action>> attacks;
    const int gate = open(shm::host_file_path, O_RDONLY | O_CLOEXEC);
    for (const char* file : {shm::host_file_path, shm::daemon_lock_path}) {
      attacks.push_back(std::make_unique<Action>(nobody, [file] {
        if (fork() != 0) return;  // the child waits for the lock, and ends with its parent
        prctl(PR_SET_PDEATHSIG, SIGKILL);
        wait_for_a_read_lock(file);
        for (;;) pause();
      }));
    }
    daemon.signal(end);
    daemon.exit_code();
    EXPECT_TRUE(node.becomes(Availability::unavailable, 2s)) << node->description();
    EXPECT_FALSE(shm::is_locked(gate));
    close(gate);
    EXPECT_EQ(daemon_pid(), 0);
    Process next({sftd_path(), "--foreground", "--log-level=error", "--pool-mib=16"});
    ASSERT_EQ(next.line(), "sftd: ready");
    EXPECT_TRUE(node.becomes_ready()) << node->description();
    next.signal(SIGTERM);
    next.exit_code();
    EXPECT_TRUE(node.becomes(Availability::unavailable)) << node->description();
  }
}

/// Returns the paths of all files that a daemon of the user `an_honest_user` needs.
std::vector<std::string> names_of_a_daemon() {
  return {shm::daemon_lock_path,        shm::host_file_path,     shm::roudi_socket_path, "/tmp/roudi.lock",
          "/tmp/iox-unique-roudi.lock", "/dev/shm/iceoryx_mgmt", "/dev/shm/sft_writers"};
}

class InTheWay : public OtherAccounts, public testing::WithParamInterface<const char*> {};

TEST_P(InTheWay, IsNamedWithItsOwnerAndRootGoesOn) {
  for (const std::string& name : names_of_a_daemon()) {
    shell(nobody, std::string(GetParam()) + " " + name);
    Process theirs = sftd_of(an_honest_user);
    const std::string refusal = theirs.all_output();
    EXPECT_TRUE(contains(refusal, name + " (of user nobody)")) << refusal;
    EXPECT_TRUE(contains(refusal, "rm -r " + name)) << refusal;
    EXPECT_EQ(theirs.exit_code(), static_cast<int>(ExitCode::failed)) << name;
    { const RunningSftd of_root = start_sftd_with_groups(); }
    EXPECT_FALSE(fs::exists(name)) << name;
  }
}

INSTANTIATE_TEST_SUITE_P(OfADaemon, InTheWay,
                         testing::Values("umask 077; touch", "umask 000; touch", "mkdir -m 700",
                                         "mkfifo -m 666", "ln -s /etc/passwd"),
                         [](const auto& way) { return "Way" + std::to_string(way.index); });

TEST_F(OtherAccounts, PutADirectoryThatIsNotEmptyInTheWayAndRootMovesItAside) {
  for (const std::string& name : names_of_a_daemon())
    shell(nobody, "mkdir " + name + " && touch " + name + "/file");
  const RunningSftd of_root = start_sftd_with_groups();
  EXPECT_TRUE(fs::is_regular_file(shm::host_file_path));
}

TEST_F(OtherAccounts, GetOneListOfAllFilesThatAKilledDaemonOfAnotherUserLeft) {
  Process daemon = sftd_of(nobody);
  ASSERT_EQ(daemon.line(), "sftd: ready");
  daemon.kill();
  Process theirs = sftd_of(an_honest_user);
  const std::string refusal = theirs.all_output();
  for (const char* name :
       {shm::daemon_lock_path, shm::host_file_path, shm::roudi_socket_path, "/dev/shm/iceoryx_mgmt"})
    EXPECT_TRUE(contains(refusal, std::string(name) + " (of user nobody)")) << refusal;
  EXPECT_FALSE(contains(refusal, "is running")) << refusal;
  EXPECT_EQ(theirs.exit_code(), static_cast<int>(ExitCode::failed));
  const auto command = refusal.find("rm -r ");
  ASSERT_NE(command, std::string::npos);
  shell({0, 0}, refusal.substr(command));
  Process again = sftd_of(an_honest_user);
  EXPECT_EQ(again.line(), "sftd: ready");
  again.signal(SIGTERM);
  again.exit_code();
}

/// Returns the route to a reader that has announced a doorbell in the page with the id `page`.
core::Route route_to(std::uint64_t page) {
  return {.reader = 7, .destination = core::DoorbellAddress{page, 0}, .selection = frame_type().full()};
}

std::string make_page(const Identity& owner, std::uint64_t id) {
  const std::string path = DoorbellPage::path_of(id);
  shell(owner,
        "umask 0; truncate -s " + std::to_string(DoorbellPage::slots * sizeof(core::Doorbell)) + " " + path);
  return path;
}

TEST_F(OtherAccounts, CanShortenNoPageOfDoorbellsThatAPublisherRings) {
  const RunningSftd daemon = start_sftd_with_groups();
  Node node(no_daemon());
  ASSERT_TRUE(node.becomes_ready()) << node->description();
  Writer writer(node, 1);
  const std::string path = make_page(nobody, 0x77);
  const std::string why = writer.port().why_unreachable(route_to(0x77));
  EXPECT_TRUE(contains(why, path + ": it belongs to user nobody")) << why;
  writer.port().set_routes({route_to(0x77)});
  EXPECT_EQ(writer.send_frame(), core::SendStatus::sent);
  shell(nobody, "truncate -s 0 " + path);
  EXPECT_EQ(writer.send_frame(), core::SendStatus::sent);
  const std::string fifo = DoorbellPage::path_of(0x78);
  shell(nobody, "mkfifo -m 666 " + fifo);
  EXPECT_TRUE(contains(writer.port().why_unreachable(route_to(0x78)), "FIFO of user nobody"));
}

TEST_F(OtherAccounts, AreWokenByTheirDoorbellsIfTheDaemonServesThem) {
  const RunningSftd daemon = start_sftd_with_groups();
  Node node(no_daemon());
  ASSERT_TRUE(node.becomes_ready()) << node->description();
  Writer writer(node, 1);
  for (const Identity& user : {a_reader, a_writer}) {
    Process reader = start(user, {"listen"});
    const std::uint64_t page = std::stoull(reader.line());
    EXPECT_EQ(writer.port().why_unreachable(route_to(page)), "") << user.user;
  }
}

TEST_F(OtherAccounts, CannotDisturbTheRemovalOfOldDoorbellPages) {
  DoorbellPage::sweep();  // removes the pages of earlier tests
  shell(nobody,
        "mkfifo -m 666 /dev/shm/sft_bell_0000000000000001; mkdir /dev/shm/sft_bell_0000000000000002;"
        "ln -s /etc/passwd /dev/shm/sft_bell_0000000000000003");
  EXPECT_EQ(DoorbellPage::sweep(), 0U);
  EXPECT_TRUE(fs::exists("/etc/passwd"));
}

}  // namespace
}  // namespace sft::test
