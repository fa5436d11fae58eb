// The life of sftd. Only one daemon runs on a host. The daemon starts and ends when it should, and reports
// the reason if it cannot start.
#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "shm_transport/host/host_file.h"
#include "shm_transport/host/iceoryx.h"
#include "shm_transport/host/socket_address.h"
#include "tests/support/test_seed.h"
#include "tests/transports/shm/shm_fixture.h"

namespace sft::test {
namespace {

using core::Availability;

class Sftd : public ShmTest {};

int bound_socket(const char* path) {
  const int bound = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  const sockaddr_un address = shm::socket_address(path);
  EXPECT_EQ(bind(bound, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  return bound;
}

/// A socket at the path, as if another program listened on it.
class Listener {
 public:
  explicit Listener(const char* path) : path_(path), socket_(bound_socket(path)) {}
  ~Listener() {
    die();
    unlink(path_.c_str());
  }
  /// Closes the socket but leaves its file, as if the listening process was killed.
  void die() {
    if (socket_ >= 0) close(socket_);
    socket_ = -1;
  }

 private:
  std::string path_;
  int socket_;
};

bool has(const std::vector<std::string>& names, const std::string& name) {
  return std::ranges::find(names, name) != names.end();
}

std::vector<std::string> open_files(pid_t pid) {
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/" + std::to_string(pid) + "/fd")) {
    files.push_back(std::filesystem::read_symlink(entry.path()));
  }
  return files;
}

TEST_F(Sftd, IsStartedByTheFirstNodeThatNeedsIt) {
  Node node;
  EXPECT_EQ(node.poll(), Availability::starting);
  EXPECT_TRUE(node.becomes_ready()) << node->description();
  EXPECT_TRUE(is_alive(daemon_pid()));
  EXPECT_TRUE(node->host_token().known());
}

TEST_F(Sftd, IsFoundByLaterNodesUnderTheSameToken) {
  Node first;
  ASSERT_TRUE(first.becomes_ready()) << first->description();
  Node second(no_daemon());
  ASSERT_TRUE(second.becomes_ready()) << second->description();
  EXPECT_EQ(first->host_token(), second->host_token());
}

TEST_F(Sftd, InheritsNothingFromTheProgramThatStartsIt) {
  // Inherited by programs that are started, since O_CLOEXEC is missing.
  const int leaky = open("/tmp/of_the_program", O_RDWR | O_CREAT, 0600);
  Node node;
  ASSERT_TRUE(node.becomes_ready()) << node->description();
  EXPECT_FALSE(has(open_files(daemon_pid()), "/tmp/of_the_program"));
  EXPECT_NE(getsid(daemon_pid()), getsid(0));
  close(leaky);
}

/// Starts a program through the shell. `limits` are commands that set the limits of resources first.
Process with_limits(const std::string& limits, const std::vector<std::string>& command) {
  std::vector<std::string> words{"/bin/sh", "-c", limits + R"(; exec "$@")", "sh"};
  words.insert(words.end(), command.begin(), command.end());
  return Process(words);
}

TEST_F(Sftd, HasItsOwnLimitsWhateverThoseOfTheProgramThatStartsItAre) {
  Process daemon = with_limits("ulimit -S -n 64; ulimit -S -t 100",
                               {sftd_path(), "--foreground", "--log-level=error", "--pool-mib=16"});
  ASSERT_EQ(daemon.line(), "sftd: ready");
  std::ifstream limits("/proc/" + std::to_string(daemon_pid()) + "/limits");
  for (std::string line; std::getline(limits, line);) {
    std::istringstream words(line);
    std::string max, name, what, soft, hard;
    words >> max >> name >> what >> soft >> hard;
    if (name != "open" && name != "cpu")
      // Skips other limits; the lines are "Max open files 64 1024 files" and "Max cpu time 9 9 seconds".
      continue;
    EXPECT_EQ(soft, hard) << line;
  }
}

/// Runs the shell commands and then sftd in a mount namespace of their own. Returns the output.
std::string output_after(const std::string& commands) {
  Process daemon({"/usr/bin/unshare", "--mount", "sh", "-ec", commands + R"(; exec "$@")", "sh", sftd_path(),
                  "--foreground", "--pool-mib=16"});
  std::string output = daemon.all_output();
  EXPECT_NE(daemon.exit_code(), 0);
  return output;
}

TEST_F(Sftd, SaysWhichPartOfTheSystemItLacks) {
  const auto covered = [](const std::string& directory, const std::string& options = "size=1m") {
    return output_after("mount -t tmpfs -o " + options + " tmpfs " + directory);
  };
  EXPECT_TRUE(contains(covered("/proc"), "/proc is not mounted: mount it"));
  EXPECT_TRUE(contains(covered("/tmp", "ro"), "/tmp is read-only: mount a tmpfs there"));
  EXPECT_TRUE(contains(covered("/dev/shm", "ro"), "/dev/shm is read-only: mount a tmpfs there"));
  EXPECT_TRUE(contains(covered("/dev"), "/dev/shm is not there: mount a tmpfs there"));
}

TEST_F(Sftd, RefusesLimitsWithWhichItCouldNotServeAllProgramsAndNamesThem) {
  Process few = with_limits("ulimit -n 64", {sftd_path(), "--foreground", "--pool-mib=16"});
  EXPECT_TRUE(contains(few.all_output(), "64 file descriptors"));
  EXPECT_NE(few.exit_code(), 0);
  Process briefly = with_limits("ulimit -t 100", {sftd_path(), "--foreground", "--pool-mib=16"});
  EXPECT_TRUE(contains(briefly.all_output(), "100 s of processor time"));
}

TEST_F(Sftd, OfConcurrentStartsExactlyOneSurvives) {
  std::vector<Process> starts;
  for (int i = 0; i < 6; ++i) starts.emplace_back(std::vector<std::string>{sftd_path(), "--pool-mib=16"});
  int losers = 0;
  for (Process& start : starts) {
    const std::string output = start.all_output();
    EXPECT_EQ(start.exit_code(), 0) << output;
    losers += contains(output, "already running") ? 1 : 0;
  }
  EXPECT_EQ(losers, 5);
  Node node(no_daemon());
  EXPECT_TRUE(node.becomes_ready()) << node->description();
}

/// Returns the process ids of all daemons on this host, as text.
std::vector<std::string> daemons() {
  std::vector<std::string> found;
  for (const std::string& name : names_in("/proc")) {
    std::string program;
    std::getline(std::ifstream("/proc/" + name + "/comm"), program);
    if (program == "sftd" && name.find_first_not_of("0123456789") == std::string::npos) found.push_back(name);
  }
  return found;
}

// Each daemon that starts fills its memory with zeros, which takes some time. So only longer runs start
// thirty nodes.
TEST_F(Sftd, RunsOnceIfManyNodesStartItAtOnce) {
  const ShmOfSize small(128);
  const std::uint64_t nodes = std::min<std::uint64_t>(test_rounds(8), 30);
  std::vector<Process> peers;
  for (std::uint64_t i = 0; i < nodes; ++i) peers.push_back(start_peer({"attend"}));
  for (Process& peer : peers) EXPECT_EQ(peer.line(70s), "ready");
  // The other daemons end as soon as they find the first one.
  EXPECT_TRUE(eventually([] { return daemons().size() == 1; })) << daemons().size();
  EXPECT_EQ(daemons(), std::vector<std::string>{std::to_string(daemon_pid())});
}

/// Returns the kernel's flags for all mappings of files with this name in the process.
std::vector<std::string> mapping_flags(pid_t pid, const std::string& file) {
  std::vector<std::string> flags;
  bool of_file = false;
  std::ifstream smaps("/proc/" + std::to_string(pid) + "/smaps");
  for (std::string line; std::getline(smaps, line);) {
    const bool is_mapping = !line.empty() && std::isupper(static_cast<unsigned char>(line[0])) == 0;
    if (is_mapping)
      // The following lines begin with a capital letter and describe this mapping.
      of_file = contains(line, file);
    if (of_file && line.starts_with("VmFlags:")) flags.push_back(line + " ");
  }
  return flags;
}

TEST_F(Sftd, ItsMemoryIsInNobodysCoreDump) {
  Node node;
  ASSERT_TRUE(node.becomes_ready()) << node->description();
  for (const pid_t pid : {getpid(), daemon_pid()}) {
    const auto flags = mapping_flags(pid, "/dev/shm/");
    EXPECT_GE(flags.size(), 2U);
    for (const std::string& mapping : flags) EXPECT_TRUE(contains(mapping, " dd ")) << pid << ": " << mapping;
  }
}

TEST_F(Sftd, LendsSamplesOf16MiBWhere256MiBAreShared) {
  const ShmOfSize small(256);
  Process daemon({sftd_path(), "--foreground", "--log-level=warning"});
  ASSERT_EQ(daemon.line(), "sftd: ready");  // the first line, so no warning was written
  Node node(no_daemon());
  ASSERT_TRUE(node.becomes_ready()) << node->description();
  Writer writer(node, 1);
  EXPECT_TRUE(writer.loan(16 << 20));
  daemon.signal(SIGTERM);
  daemon.exit_code();
}

TEST_F(Sftd, LendsSamplesOf64MiBWhere1200MiBAreShared) {
  const ShmOfSize host(1200);
  Process daemon({sftd_path(), "--foreground", "--log-level=warning"});
  ASSERT_EQ(daemon.line(), "sftd: ready");  // the first line, so no warning was written
  Node node(no_daemon());
  ASSERT_TRUE(node.becomes_ready()) << node->description();
  Writer writer(node, 1);
  EXPECT_TRUE(writer.loan(64 << 20));
  daemon.signal(SIGTERM);
  daemon.exit_code();
}

TEST_F(Sftd, SaysHowMuchMemoryItTook) {
  Process daemon({sftd_path(), "--foreground", "--pool-mib=16"});
  const std::string line = daemon.line();
  EXPECT_TRUE(contains(line, "MiB for samples: ")) << line;
  EXPECT_TRUE(contains(line, " x 4 KiB")) << line;
}

TEST_F(Sftd, TakesThePoolsThatItsConfigurationNames) {
  std::ofstream("/tmp/sftd.toml") << "log_level = 'error'\n[[pool]]\nsize_kib = 64\ncount = 3\n";
  Process daemon({sftd_path(), "--foreground", "--config=/tmp/sftd.toml"});
  ASSERT_EQ(daemon.line(), "sftd: ready");
  Node node(no_daemon());
  ASSERT_TRUE(node.becomes_ready()) << node->description();
  EXPECT_EQ(ChunkCounter(node, 100).free(), 3U);
  EXPECT_EQ(ChunkCounter(node, 100'000).free(), 0U);
}

TEST_F(Sftd, RefusesPoolsThatDoNotFit) {
  const ShmOfSize small(200);
  std::ofstream("/tmp/sftd.toml") << "[[pool]]\nsize_kib = 1024\ncount = 200\n";
  Process daemon({sftd_path(), "--foreground", "--config=/tmp/sftd.toml"});
  EXPECT_TRUE(contains(daemon.all_output(), "/dev/shm has 200.0 MiB"));
  EXPECT_EQ(daemon.exit_code(), 1);
}

TEST_F(Sftd, RefusesAWrongConfigurationAndNamesTheLine) {
  std::ofstream("/tmp/sftd.toml") << "total_mib = 16\nidle_exit = 3\n";
  Process daemon({sftd_path(), "--config=/tmp/sftd.toml"});
  const std::string output = daemon.all_output();
  EXPECT_TRUE(output.starts_with("sftd: /tmp/sftd.toml:2: idle_exit: unknown key")) << output;
  EXPECT_EQ(daemon.exit_code(), 7);
}

TEST_F(Sftd, RefusesAConfigurationFileThatDoesNotExist) {
  Process daemon({sftd_path(), "--config=/tmp/nowhere.toml"});
  EXPECT_TRUE(daemon.all_output().starts_with("sftd: /tmp/nowhere.toml: "));
  EXPECT_EQ(daemon.exit_code(), 7);
}

TEST_F(Sftd, GivesOneProgramNoMoreThanItsLimits) {
  std::ofstream("/tmp/sftd.toml") << "total_mib = 16\nlog_level = 'error'\n"
                                     "[limits]\nprocesses = 1\npublishers_per_process = 2\n";
  Process daemon({sftd_path(), "--foreground", "--config=/tmp/sftd.toml"});
  ASSERT_EQ(daemon.line(), "sftd: ready");
  Node node(no_daemon());
  ASSERT_TRUE(node.becomes_ready()) << node->description();
  const Writer first(node, 1);
  const Writer second(node, 2);
  const auto third = node->open_writer({.id = 3, .type = &frame_type()});
  ASSERT_FALSE(third);
  EXPECT_TRUE(contains(third.error().message, "its limits")) << third.error().message;
  Process other = start_peer({"knock"});
  const std::string answer = other.line();
  EXPECT_TRUE(contains(answer, "as many programs as its configuration allows")) << answer;
}

/// The socket of a service manager, which receives the messages of sftd.
class ServiceSocket {
 public:
  explicit ServiceSocket(const char* path) : socket_(bound_socket(path)) {
    const timeval deadline{10, 0};
    setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &deadline, sizeof deadline);
    setenv("NOTIFY_SOCKET", path, 1);
  }
  ~ServiceSocket() {
    unsetenv("NOTIFY_SOCKET");
    close(socket_);
  }
  std::string next() const {
    char text[512];
    const ssize_t bytes = recv(socket_, text, sizeof text, 0);
    return {text, static_cast<std::size_t>(std::max<ssize_t>(bytes, 0))};
  }

 private:
  int socket_;
};

TEST_F(Sftd, TellsItsServiceManagerWhenItIsReadyAndWhenItEnds) {
  const ServiceSocket manager("/tmp/service_manager");
  Process daemon({sftd_path(), "--foreground", "--log-level=error", "--pool-mib=16"});
  const std::string news = manager.next();
  EXPECT_TRUE(news.starts_with("READY=1\nSTATUS=16.0 MiB for samples")) << news;
  EXPECT_NE(daemon_pid(), 0) << "sftd said that it is ready before it was";
  daemon.signal(SIGTERM);
  EXPECT_EQ(manager.next(), "STOPPING=1");
  EXPECT_EQ(daemon.exit_code(), 0);
}

TEST_F(Sftd, LeavesNothingBehindWhenItIsTerminated) {
  const auto tmp_before = names_in("/tmp").size();
  for (const int signal : {SIGTERM, SIGINT}) {
    Process daemon({sftd_path(), "--foreground", "--log-level=error", "--pool-mib=16"});
    ASSERT_EQ(daemon.line(), "sftd: ready");
    daemon.signal(signal);
    EXPECT_EQ(daemon.exit_code(), 0);
    EXPECT_EQ(names_in("/dev/shm").size(), 0U);
    EXPECT_EQ(names_in("/tmp").size(), tmp_before);
  }
}

TEST_F(Sftd, StartsAgainAfterItWasKilled) {
  for (int round = 0; round < 3; ++round) {
    Process daemon({sftd_path(), "--foreground", "--log-level=error", "--pool-mib=16"});
    ASSERT_EQ(daemon.line(), "sftd: ready");
    daemon.kill();
    EXPECT_EQ(daemon_pid(), 0) << "the host file of a dead daemon must not count";
  }
  Node node;
  EXPECT_TRUE(node.becomes_ready()) << node->description();
}

TEST_F(Sftd, RemovesTheSocketsOfDeadProgramsAndNoOthers) {
  Listener dead("/tmp/sft_node_123_0badcafe");
  Listener alive("/tmp/sft_node_124_0badcafe");
  Listener foreign("/tmp/other_program");
  dead.die();
  foreign.die();
  Node node;
  ASSERT_TRUE(node.becomes_ready()) << node->description();
  EXPECT_EQ(names_in("/tmp", "sft_node_123").size(), 0U);
  EXPECT_EQ(names_in("/tmp", "sft_node_124").size(), 1U);
  EXPECT_EQ(names_in("/tmp", "other_program").size(), 1U);
}

TEST_F(Sftd, RefusesADevShmThatIsTooSmallAndSaysWhatToDo) {
  const ShmOfSize small(64);
  Process daemon({sftd_path()});
  const std::string output = daemon.all_output();
  EXPECT_EQ(daemon.exit_code(), 1);
  EXPECT_TRUE(contains(output, "64.0 MiB")) << output;
  EXPECT_TRUE(contains(output, "--shm-size")) << output;
}

TEST_F(Sftd, LeavesLargeChunksOutIfThereIsLittleSpaceAndSaysSo) {
  const ShmOfSize small(140);
  Process daemon({sftd_path(), "--foreground", "--log-level=warning"});
  const std::string first = daemon.line();
  EXPECT_TRUE(contains(first, "do not fit")) << first;
  EXPECT_EQ(daemon.line(), "sftd: ready");
  Node node;
  ASSERT_TRUE(node.becomes_ready()) << node->description();
  Writer writer(node, 1);
  EXPECT_TRUE(writer.loan(1'000'000));
  EXPECT_FALSE(writer.loan(8'000'000));
  daemon.signal(SIGTERM);
  daemon.exit_code();
}

TEST_F(Sftd, DoesNotStartBesideAForeignRoudi) {
  const Listener roudi(shm::roudi_socket_path);
  Process daemon({sftd_path()});
  const std::string output = daemon.all_output();
  EXPECT_EQ(daemon.exit_code(), 2);
  EXPECT_TRUE(contains(output, "iox-roudi")) << output;
}

TEST_F(Sftd, EndsAfterBeingIdleIfAskedTo) {
  Process daemon({sftd_path(), "--foreground", "--log-level=error", "--pool-mib=16", "--idle-exit=1"});
  ASSERT_EQ(daemon.line(), "sftd: ready");
  {
    Node node(no_daemon());
    ASSERT_TRUE(node.becomes_ready()) << node->description();
    EXPECT_FALSE(eventually([] { return daemon_pid() == 0; }, 2s))
        << "sftd must not end while it has a client";
  }
  EXPECT_EQ(daemon.exit_code(), 0);
}

TEST_F(Sftd, ThatANodeStartedEndsWhenNobodyHasUsedItForAsLongAsTheNodeSaid) {
  shm::ShmOptions options = own_daemon();
  options.daemon_idle_exit = 1s;
  {
    Node node(options);
    ASSERT_TRUE(node.becomes_ready()) << node->description();
  }
  EXPECT_TRUE(eventually([] { return daemon_pid() == 0 && names_in("/dev/shm", "").empty(); }));
}

TEST_F(Sftd, ThatANodeStartedEndsAfterFiveMinutesWithoutProgramsIfNothingElseIsSaid) {
  Node node;
  ASSERT_TRUE(node.becomes_ready()) << node->description();
  Process status({sftd_path(), "status"});
  EXPECT_TRUE(contains(status.all_output(), "idle exit after 300 s"));
}

/// Registers a process with this name at sftd, as any program of sftd's group can.
void register_with_sftd(const std::string& name) {
  const int socket = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  const sockaddr_un address = shm::socket_address(shm::roudi_socket_path);
  iox::runtime::IpcMessage request;
  request << iox::runtime::IpcMessageTypeToString(iox::runtime::IpcMessageType::REG) << name << "1"
          << std::to_string(geteuid()) << "0"
          << static_cast<iox::cxx::Serialization>(iox::version::VersionInfo::getCurrentVersion()).toString();
  const std::string text = request.getMessage();
  EXPECT_GT(sendto(socket, text.c_str(), text.size() + 1, 0, reinterpret_cast<const sockaddr*>(&address),
                   sizeof address),
            0);
  close(socket);
}

TEST_F(Sftd, RemovesNoFileThatAProgramNamesAsItsSocket) {
  std::filesystem::create_directory("/tmp/home");
  for (const char* file : {"/tmp/home/notes", "/tmp/sft_notes"}) std::ofstream(file) << "mine";
  Node node;
  ASSERT_TRUE(node.becomes_ready()) << node->description();
  for (const char* name : {"home/notes", "../tmp/home/notes", "sft_/../home/notes", "sft_notes", "sftd.lock"})
    register_with_sftd(name);
  Listener last("/tmp/sft_witness_1_0badcafe");
  register_with_sftd("sft_witness_1_0badcafe");
  last.die();
  EXPECT_TRUE(eventually([] { return names_in("/tmp", "sft_witness").empty(); }))
      << "sftd has not removed the dead process";
  EXPECT_TRUE(std::filesystem::exists("/tmp/home/notes"));
  EXPECT_TRUE(std::filesystem::exists("/tmp/sft_notes"));
  EXPECT_TRUE(std::filesystem::exists(shm::daemon_lock_path));
}

TEST_F(Sftd, StartsAfreshWithItsProgramsAfterItsFilesWereRemoved) {
  Node node;
  ASSERT_TRUE(node.becomes_ready()) << node->description();
  for (const char* directory : {"/dev/shm", "/tmp"}) {
    const core::HostToken before = node->host_token();
    for (const std::string& name : names_in(directory)) {
      const std::string path = std::string(directory) + "/" + name;
      // Skips directories, which may contain the programs.
      if (!std::filesystem::is_directory(path)) unlink(path.c_str());
    }
    ASSERT_TRUE(eventually([&] {
      return node.poll() == Availability::ready && !(node->host_token() == before);
    })) << directory
        << ": " << node->description();
    Process newcomer = start_peer({"attend"});
    EXPECT_EQ(newcomer.line(), "ready") << directory;
  }
}

class NodeWithoutDaemon : public ShmTest {};

TEST_F(NodeWithoutDaemon, SaysThatDevShmIsTooSmall) {
  const ShmOfSize small(64);
  Node node;
  ASSERT_TRUE(node.becomes(Availability::unavailable));
  EXPECT_TRUE(contains(node->description(), "64.0 MiB")) << node->description();
}

TEST_F(NodeWithoutDaemon, NamesAMissingProgram) {
  shm::ShmOptions options;
  options.daemon_path = "/nowhere/sftd";
  Node node(options);
  ASSERT_TRUE(node.becomes(Availability::unavailable));
  EXPECT_TRUE(contains(node->description(), "/nowhere/sftd")) << node->description();
}

/// Returns options under which a node starts, in place of sftd, a program that never becomes a daemon.
shm::ShmOptions endless_start() {
  std::ofstream("/tmp/endless") << "#!/bin/sh\nexec sleep 1000\n";
  std::filesystem::permissions("/tmp/endless", std::filesystem::perms::owner_all);
  shm::ShmOptions options;
  options.daemon_path = "/tmp/endless";
  options.start_deadline = 50ms;
  return options;
}

bool has_children() { return waitpid(-1, nullptr, WNOHANG) >= 0 || errno != ECHILD; }

TEST_F(NodeWithoutDaemon, LeavesNoChildBehindAtTheDeadline) {
  Node node(endless_start());
  ASSERT_TRUE(node.becomes(Availability::unavailable));
  EXPECT_TRUE(contains(node->description(), "does not get ready")) << node->description();
  EXPECT_FALSE(has_children());
}

TEST_F(NodeWithoutDaemon, LeavesNoChildBehindWhenTheNodeIsDestroyed) {
  {
    Node node(endless_start());
    node.poll();
    EXPECT_TRUE(has_children());
  }
  EXPECT_FALSE(has_children());
}

TEST_F(NodeWithoutDaemon, StartsNoDaemonIfItsOptionsForbidIt) {
  Node node(no_daemon());
  ASSERT_TRUE(node.becomes(Availability::unavailable));
  EXPECT_TRUE(contains(node->description(), "run sftd")) << node->description();
}

TEST_F(NodeWithoutDaemon, DoesNotUseAForeignRoudi) {
  const Listener roudi(shm::roudi_socket_path);
  Node node;
  ASSERT_TRUE(node.becomes(Availability::unavailable));
  EXPECT_TRUE(contains(node->description(), "iox-roudi")) << node->description();
}

TEST_F(NodeWithoutDaemon, NamesAnSftdThatHasAnotherSharedMemory) {
  Node first;
  ASSERT_TRUE(first.becomes_ready()) << first->description();
  Process peer = [] {
    const ShmOfSize other(200);
    Process started = start_peer({"attend", "5"});
    EXPECT_TRUE(contains(started.line(), "another /dev/shm"));
    return started;
  }();
  EXPECT_TRUE(first.becomes_ready()) << first->description();
}

TEST_F(NodeWithoutDaemon, IgnoresAHostFileThatNobodyHasLocked) {
  std::ofstream(shm::host_file_path) << "token 000102030405060708090a0b0c0d0e0f\npid 1\nports 64\nend\n";
  Node node(no_daemon());
  EXPECT_TRUE(node.becomes(Availability::unavailable));
  EXPECT_FALSE(node->host_token().known());
}

TEST_F(NodeWithoutDaemon, NamesAnSftdOfAnotherVersion) {
  auto lock = shm::FileLock::take(shm::host_file_path);
  ASSERT_TRUE(lock);
  const std::string sign = "token 000102030405060708090a0b0c0d0e0f\npid 1\nports 64\nend\n";
  ASSERT_EQ(write(lock->descriptor(), sign.data(), sign.size()), static_cast<ssize_t>(sign.size()));
  Node node(no_daemon());
  ASSERT_TRUE(node.becomes(Availability::unavailable));
  EXPECT_TRUE(contains(node->description(), "another version")) << node->description();
  lock->remove();
}

TEST_F(NodeWithoutDaemon, OpensNoPorts) {
  Node node(no_daemon());
  node.poll();
  EXPECT_FALSE(node->open_writer({.id = 1, .type = &frame_type()}));
  EXPECT_FALSE(node->open_reader({.id = 1, .type = &frame_type(), .doorbell = {}}));
}

TEST_F(NodeWithoutDaemon, FindsADaemonThatIsStartedLater) {
  Node node(no_daemon());
  ASSERT_TRUE(node.becomes(Availability::unavailable));
  Process daemon({sftd_path(), "--foreground", "--log-level=error", "--pool-mib=16"});
  EXPECT_TRUE(node.becomes_ready()) << node->description();
}

TEST_F(NodeWithoutDaemon, FindsADaemonAtOnceHoweverOftenItHasFailedToStartOne) {
  shm::ShmOptions options;
  options.daemon_path = "/nowhere/sftd";
  Node node(options);
  auto now = Clock::now();
  for (int i = 0; i < 10; ++i) EXPECT_EQ(node->poll(now += 20s), Availability::unavailable);
  Process daemon({sftd_path(), "--foreground", "--log-level=error", "--pool-mib=16"});
  ASSERT_EQ(daemon.line(), "sftd: ready");
  EXPECT_TRUE(eventually([&] { return node->poll(now) == Availability::ready; })) << node->description();
}

TEST_F(NodeWithoutDaemon, IsServedAsSoonAsADaemonGoesOnThatWasStopped) {
  Process daemon({sftd_path(), "--foreground", "--log-level=error", "--pool-mib=16"});
  ASSERT_EQ(daemon.line(), "sftd: ready");
  daemon.signal(SIGSTOP);
  ASSERT_TRUE(eventually([&] { return is_stopped(daemon.pid()); }));
  Node node(no_daemon());
  auto now = Clock::now();
  EXPECT_EQ(node->poll(now), Availability::starting);
  for (int i = 0; i < 20; ++i) EXPECT_EQ(node->poll(now += 5s), Availability::unavailable);
  EXPECT_TRUE(contains(node->description(), "does not answer")) << node->description();
  daemon.signal(SIGCONT);
  EXPECT_TRUE(eventually([&] { return node->poll(now) == Availability::ready; })) << node->description();
}

}  // namespace
}  // namespace sft::test
