#include "tests/transports/shm/shm_fixture.h"
#include "core/platform/text_of.h"

#include <fcntl.h>
#include <grp.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "shm_transport/host/host_file.h"

namespace sft::test {

namespace {

bool become(const Identity& identity) {
  return setgroups(identity.other_groups.size(), identity.other_groups.data()) == 0 &&
         setgid(identity.group) == 0 && setuid(identity.user) == 0;
}

/// Repeats the request if the daemon did not answer in time. The daemon may be busy after the death of
/// another process.
template <class Ask>
auto patiently(Ask ask) {
  auto answer = ask();
  eventually([&] {
    if (answer || answer.error().code != Errc::unavailable) return true;
    answer = ask();
    return false;
  });
  return answer;
}

}  // namespace

Process::Process(const std::vector<std::string>& command, const Identity* as) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return;
  std::vector<char*> arguments;
  for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  pid_ = fork();
  if (pid_ == 0) {
    dup2(ends[1], 1);
    dup2(ends[1], 2);
    if (as != nullptr && !become(*as)) _exit(126);
    execv(arguments[0], arguments.data());
    _exit(127);
  }
  close(ends[1]);
  output_ = ends[0];
}

Process::Process(Process&& other) noexcept
    : pid_(std::exchange(other.pid_, -1)),
      output_(std::exchange(other.output_, -1)),
      status_(other.status_),
      text_(std::move(other.text_)) {}

Process::~Process() {
  kill();
  if (output_ >= 0) close(output_);
}

bool Process::runs() const {
  siginfo_t end{};
  return pid_ > 0 && waitid(P_PID, static_cast<id_t>(pid_), &end, WEXITED | WNOHANG | WNOWAIT) == 0 &&
         end.si_pid == 0;
}

void Process::signal(int signal) const {
  if (pid_ > 0) ::kill(pid_, signal);
}

void Process::kill() {
  signal(SIGKILL);
  reap();
}

void Process::reap() {
  if (pid_ > 0) waitpid(pid_, &status_, 0);
  pid_ = -1;
}

int Process::exit_code() {
  reap();
  return WIFEXITED(status_) ? WEXITSTATUS(status_) : -1;
}

std::string Process::line(Clock::duration within) {
  const auto deadline = Clock::now() + within;
  for (;;) {
    if (const auto end = text_.find('\n'); end != std::string::npos) {
      std::string line = text_.substr(0, end);
      text_.erase(0, end + 1);
      return line;
    }
    const auto wait_ms =
        std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
    pollfd wanted{output_, POLLIN, 0};
    if (wait_ms <= 0 || ::poll(&wanted, 1, static_cast<int>(wait_ms)) <= 0) return {};
    char bytes[512];
    const ssize_t size = read(output_, bytes, sizeof bytes);
    if (size <= 0) return {};
    text_.append(bytes, static_cast<std::size_t>(size));
  }
}

std::string Process::all_output() {
  char bytes[512];
  for (ssize_t size = 0; (size = read(output_, bytes, sizeof bytes)) > 0;) {
    text_.append(bytes, static_cast<std::size_t>(size));
  }
  return std::exchange(text_, {});
}

std::string sftd_path() { return program_directory() + "/sftd"; }

Process start_peer(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), program_directory() + "/shm_peer");
  return Process(arguments);
}

pid_t daemon_pid() {
  const auto found = shm::HostMonitor::look({.everybody = true});
  return found.monitor ? found.monitor->file().pid : 0;
}

bool is_alive(pid_t pid) { return pid > 0 && ::kill(pid, 0) == 0; }

bool is_stopped(pid_t pid) {
  const std::filesystem::path threads = "/proc/" + std::to_string(pid) + "/task";
  for (const auto& thread : std::filesystem::directory_iterator(threads)) {
    const std::string text = core::text_of(thread.path() / "stat");
    // the state follows the name, and the name may contain any characters
    const auto behind_name = text.rfind(") ");
    if (behind_name == std::string::npos || text[behind_name + 2] != 'T') return false;
  }
  return true;
}

shm::ShmOptions own_daemon() {
  shm::ShmOptions options;
  options.daemon_path = sftd_path();
  options.port_wait = options.port_deadline;  // waits as long as a node that repeats its requests
  return options;
}

shm::ShmOptions no_daemon() {
  shm::ShmOptions options = own_daemon();
  options.start_daemon = false;
  return options;
}

shm::ShmOptions no_daemon_and_held_at_most(std::uint32_t samples) {
  shm::ShmOptions options = no_daemon();
  options.held_limit = samples;
  return options;
}

Node::Node(const shm::ShmOptions& options) : transport_(shm::open_shm_transport(options).value()) {}

bool Node::becomes(core::Availability wanted, std::chrono::milliseconds within) {
  return eventually([&] { return poll() == wanted; }, within);
}

Writer::Writer(Node& node, core::EndpointId id) : id_(id) {
  auto port = patiently([&] { return node->open_writer({.id = id, .type = &frame_type()}); });
  EXPECT_TRUE(port) << port.error().message;
  if (!port) return;
  port_ = std::move(*port);
  port_->set_routes(
      {{.reader = reader_id, .destination = core::DoorbellAddress{}, .selection = frame_type().full()}});
}

core::SampleHandle Writer::loan(std::uint32_t data) { return port_->loan(frame_bytes(data)); }

core::SendStatus Writer::send(const core::SampleHandle& sample, std::uint32_t data) {
  write_frame(*sample, id_, ++sequence_, data);
  return port_->send(sample);
}

core::SendStatus Writer::send_frame(std::uint32_t data) {
  const core::SampleHandle sample = loan(data);
  return sample ? send(sample, data) : core::SendStatus::dropped;
}

Reader::Reader(Node& node, std::uint32_t depth, core::EndpointId id, std::uint64_t depth_bytes) {
  auto port = node->open_reader(
      {.id = id, .type = &frame_type(), .depth = depth, .doorbell = {}, .depth_bytes = depth_bytes});
  EXPECT_TRUE(port) << port.error().message;
  if (port) port_ = std::move(*port);
}

bool Reader::connects_to(core::EndpointId writer) {
  const auto asked =
      patiently([&] { return port_->connect({.writer = writer, .max_sample_bytes = 16 << 20}); });
  EXPECT_TRUE(asked) << asked.error().message;
  return eventually([&] { return port_->connected(writer); });
}

core::SampleHandle Reader::next(std::chrono::milliseconds within) {
  core::SampleHandle sample;
  eventually([&] { return static_cast<bool>(sample = take()); }, within);
  return sample;
}

std::size_t ChunkCounter::free() {
  std::vector<core::SampleHandle> loans;
  for (std::size_t i = 0;; ++i) {
    if (i == ports_.size()) {
      auto port = node_->open_writer({.id = 1'000'000 + i, .type = &frame_type()});
      if (!port) throw std::runtime_error(port.error().message);
      ports_.push_back(std::move(*port));
    }
    const std::size_t before = loans.size();
    while (core::SampleHandle loan = ports_[i]->loan(frame_bytes(data_))) loans.push_back(std::move(loan));
    if (loans.size() < before + shm::ShmOptions{}.held_limit) return loans.size();
  }
}

bool ChunkCounter::comes_to(std::size_t chunks) {
  std::size_t now_free = 0;
  const bool enough = eventually([&] {
    node_.poll();  // gives back the ports that are no longer used, to make chunks free
    return (now_free = free()) >= chunks;
  });
  if (!enough) std::printf("%zu of %zu chunks are free\n", now_free, chunks);
  return enough;
}

std::vector<std::string> names_in(const char* directory, const std::string& prefix) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(directory)) {
    if (entry.path().filename().string().starts_with(prefix)) names.push_back(entry.path().filename());
  }
  return names;
}

void ShmTest::SetUp() {
  if (!isolation_refusal().empty()) GTEST_SKIP() << isolation_refusal();
  if (shm_mebibytes_) shm_.emplace(*shm_mebibytes_);
}

void end_daemon() {
  const pid_t daemon = daemon_pid();
  if (daemon == 0) return;
  ::kill(daemon, SIGCONT);
  ::kill(daemon, SIGTERM);
  EXPECT_TRUE(eventually([daemon] { return !is_alive(daemon); })) << "sftd does not end";
}

void ShmTest::TearDown() { end_daemon(); }

void ShmNodeTest::SetUp() {
  ShmTest::SetUp();
  if (IsSkipped()) return;
  node_ = std::make_unique<Node>();
  ASSERT_TRUE(node_->becomes_ready()) << (*node_)->description();
}

void ShmNodeTest::TearDown() {
  leave();
  ShmTest::TearDown();
}

}  // namespace sft::test
