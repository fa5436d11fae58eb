#include "examples/demo/host.h"

#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "examples/demo/process.h"
#include "examples/demo/protocol.h"

namespace sft::demo {

namespace {

using std::chrono::milliseconds;

constexpr milliseconds patience_with_daemons{2'000};
constexpr milliseconds patience_with_hosts{8'000};  // roles take leave of each other, and daemons end

[[noreturn]] void give_up(std::vector<Channel>& channels, const Error& error) {
  for (Channel& channel : channels) refuse(channel, error);
  _exit(1);
}

[[noreturn]] void run_role(const Role& role, std::size_t number, std::vector<Channel>& channels) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  prctl(PR_SET_NAME, role.name.c_str());  // shown by ps and top
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  close_descriptors_except({channels[number].descriptor()});
  role.run(channels[number]);
  _exit(0);
}

/// The first process of a host: starts the roles and stays until they are gone, or until it is told to end.
[[noreturn]] void look_after_roles(const std::vector<Role>& roles, std::vector<Channel>& channels) {
  std::vector<pid_t> running;
  for (std::size_t i = 0; i < roles.size(); ++i) {
    const pid_t role = fork();
    if (role == 0) run_role(roles[i], i, channels);
    if (role > 0) running.push_back(role);
  }
  channels.clear();  // each role has its own now; where one could not be started, the demo sees it closed

  sigset_t awaited;
  sigemptyset(&awaited);
  sigaddset(&awaited, SIGCHLD);
  sigaddset(&awaited, SIGTERM);
  while (!running.empty() && sigwaitinfo(&awaited, nullptr) != SIGTERM) {
    for (pid_t gone = 0; (gone = waitpid(-1, nullptr, WNOHANG)) > 0;) std::erase(running, gone);
  }
  end_children(patience_with_daemons);
  _exit(0);
}

void block_signals_waited_for() {
  sigset_t blocked;
  sigemptyset(&blocked);
  sigaddset(&blocked, SIGCHLD);
  sigaddset(&blocked, SIGTERM);
  sigprocmask(SIG_SETMASK, &blocked, nullptr);
}

/// On this machine: sftd, started by a role, becomes a child of the process that this runs in.
[[noreturn]] void run_here(const std::vector<Role>& roles, std::vector<Channel>& channels) {
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  prctl(PR_SET_CHILD_SUBREAPER, 1);
  look_after_roles(roles, channels);
}

/// In namespaces. Only a child enters the new process namespace, as its first process; this one waits
/// outside.
[[noreturn]] void run_isolated(const HostSettings& settings, const std::vector<Role>& roles,
                               std::vector<Channel>& channels) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (const Result<void> left = leave_this_host(settings); !left) give_up(channels, left.error());
  const pid_t first = fork();
  if (first == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);  // the end of a first process is the end of all in its namespace
    if (const Result<void> mounted = mount_own_proc(); !mounted) give_up(channels, mounted.error());
    look_after_roles(roles, channels);
  }
  channels.clear();
  while (first > 0 && waitpid(first, nullptr, 0) < 0 && errno == EINTR) continue;
  _exit(0);
}

/// noexcept: an exception must not leave for the stack that was copied from the demo.
[[noreturn]] void run_host(const HostSettings& settings, const std::vector<Role>& roles,
                           std::vector<Channel>& channels) noexcept {
  setsid();  // Ctrl-C is for the demo, which then ends its hosts in order
  block_signals_waited_for();
  std::vector<int> kept;
  for (const Channel& channel : channels) kept.push_back(channel.descriptor());
  if (settings.network != nullptr) kept.push_back(settings.network->descriptor());
  close_descriptors_except(kept);
  if (settings.network == nullptr) run_here(roles, channels);
  run_isolated(settings, roles, channels);
}

}  // namespace

Result<Host> Host::start(const HostSettings& settings, const std::vector<Role>& roles) {
  std::vector<Channel> ours;
  std::vector<Channel> theirs;
  for (std::size_t i = 0; i < roles.size(); ++i) {
    Result<std::pair<Channel, Channel>> ends = Channel::make_pair();
    if (!ends) return tl::unexpected(ends.error());
    ours.push_back(std::move(ends->first));
    theirs.push_back(std::move(ends->second));
  }
  const pid_t first_process = fork();
  if (first_process < 0) return fail(Errc::system, fmt::format("fork: {}", std::strerror(errno)));
  if (first_process == 0) run_host(settings, roles, theirs);
  return Host(first_process, std::move(ours));
}

Host::~Host() {
  if (first_process_ < 0) return;
  dismiss();
  // By number: glibc 2.36 declares pidfd_open() for C only.
  const Descriptor process(static_cast<int>(syscall(SYS_pidfd_open, first_process_, 0)));
  pollfd ended{.fd = process.get(), .events = POLLIN, .revents = 0};
  int result = 0;
  do {
    result = poll(&ended, 1, static_cast<int>(patience_with_hosts.count()));
  } while (result < 0 && errno == EINTR);
  if (result <= 0) kill(first_process_, SIGKILL);
  while (waitpid(first_process_, nullptr, 0) < 0 && errno == EINTR) continue;
}

}  // namespace sft::demo
