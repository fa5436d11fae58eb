#include "tools/demo/stage/host.h"

#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>

#include "tools/demo/roles/protocol.h"
#include "tools/hosts/child_process.h"
#include "tools/hosts/own_host.h"
#include "tools/hosts/system_error.h"

namespace sft::demo {

namespace {

using std::chrono::milliseconds;

constexpr milliseconds timeout_with_daemons{2'000};
// The time in which the processes of a host must end: nodes close, and daemons end.
constexpr milliseconds timeout_with_hosts{8'000};

/// Moves the calling process into the network and mounts an empty /dev/shm and /tmp that only it and its
/// children see. Its next child becomes the first process of a new process namespace; when that child ends,
/// the kernel ends all processes in there.
Result<void> leave_this_host(const HostSettings& settings) {
  hosts::program_directory();
  return settings.network->enter()
      .and_then([] {
        return hosts::checked(unshare(CLONE_NEWNS | CLONE_NEWPID) == 0, "namespaces cannot be made");
      })
      .and_then(hosts::make_mounts_private)
      .and_then([&] { return hosts::mount_own_shm(settings.shared_memory_mib); })
      .and_then(hosts::mount_own_tmp);
}

[[noreturn]] void give_up(std::vector<Channel>& channels, const Error& error) {
  for (Channel& channel : channels) refuse(channel, error);
  _exit(1);
}

[[noreturn]] void run_role(const Role& role, std::size_t number, std::vector<Channel>& channels) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  prctl(PR_SET_NAME, role.name.c_str());  // shown by ps and top
  hosts::block_only({});
  hosts::close_descriptors_except({channels[number].descriptor()});
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
  // Each role has its own channel now. The demo sees the channel of a role that was not started as closed.
  channels.clear();

  sigset_t awaited;
  sigemptyset(&awaited);
  sigaddset(&awaited, SIGCHLD);
  sigaddset(&awaited, SIGTERM);
  while (!running.empty() && sigwaitinfo(&awaited, nullptr) != SIGTERM) {
    for (pid_t gone = 0; (gone = waitpid(-1, nullptr, WNOHANG)) > 0;) std::erase(running, gone);
  }
  hosts::end_children(timeout_with_daemons);
  _exit(0);
}

/// Runs the roles on this machine. An sftd that a role starts becomes a child of this process.
[[noreturn]] void run_here(const std::vector<Role>& roles, std::vector<Channel>& channels) {
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  prctl(PR_SET_CHILD_SUBREAPER, 1);
  look_after_roles(roles, channels);
}

/// Runs the roles in namespaces. Only a child enters the new process namespace, as its first process; this
/// process waits outside.
[[noreturn]] void run_isolated(const HostSettings& settings, const std::vector<Role>& roles,
                               std::vector<Channel>& channels) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (const Result<void> left = leave_this_host(settings); !left) give_up(channels, left.error());
  const pid_t first = fork();
  if (first == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);  // the end of a first process is the end of all in its namespace
    if (const Result<void> mounted = hosts::mount_own_proc(); !mounted) give_up(channels, mounted.error());
    look_after_roles(roles, channels);
  }
  channels.clear();
  if (first > 0) hosts::reap(first);
  _exit(0);
}

/// noexcept: an exception must not reach the stack that was copied from the demo.
[[noreturn]] void run_host(const HostSettings& settings, const std::vector<Role>& roles,
                           std::vector<Channel>& channels) noexcept {
  setsid();  // Ctrl-C is for the demo, which then ends its hosts in order
  hosts::block_only({SIGCHLD, SIGTERM});
  std::vector<int> kept;
  for (const Channel& channel : channels) kept.push_back(channel.descriptor());
  if (settings.network != nullptr) kept.push_back(settings.network->descriptor());
  hosts::close_descriptors_except(kept);
  if (settings.network == nullptr) run_here(roles, channels);
  run_isolated(settings, roles, channels);
}

}  // namespace

Result<void> become_root() {
  // The network of this machine does not belong to the new root: a process that leaves it cannot come back.
  return geteuid() == 0 ? Result<void>() : hosts::enter_user_namespace(CLONE_NEWNET);
}

Result<void> try_isolation() {
  return hosts::in_child([](int) -> Result<void> {
    if (Result<void> root = become_root(); !root) return root;
    const auto network = hosts::EmulatedNetwork::create(1);
    if (!network) return tl::unexpected(network.error());
    return leave_this_host({.network = &network->host(0)}).and_then([] {
      return hosts::in_child([](int) { return hosts::mount_own_proc(); });
    });
  });
}

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
  if (first_process < 0) return hosts::system_error("fork");
  if (first_process == 0) run_host(settings, roles, theirs);
  return Host(first_process, std::move(ours));
}

Host::~Host() {
  if (first_process_ < 0) return;
  dismiss();
  // The call is made by number, since glibc 2.36 declares pidfd_open() for C only.
  const core::FileDescriptor process(static_cast<int>(syscall(SYS_pidfd_open, first_process_, 0)));
  pollfd ended{.fd = process.get(), .events = POLLIN, .revents = 0};
  int result = 0;
  do {
    result = poll(&ended, 1, static_cast<int>(timeout_with_hosts.count()));
  } while (result < 0 && errno == EINTR);
  if (result <= 0) kill(first_process_, SIGKILL);
  hosts::reap(first_process_);
}

}  // namespace sft::demo
