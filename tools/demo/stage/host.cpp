#include "tools/demo/stage/host.h"

#include <sched.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>

#include "tools/hosts/child_process.h"
#include "tools/hosts/own_host.h"
#include "tools/hosts/system_error.h"

namespace sft::demo {

namespace {

constexpr std::chrono::seconds patience_with_children{2};

/// As fork(), but into new namespaces of these kinds. The child may only fork, wait and execute.
pid_t fork_into(unsigned long kinds) {
  return static_cast<pid_t>(syscall(SYS_clone, kinds | SIGCHLD, nullptr, nullptr, nullptr, nullptr));
}

/// Moves the calling process into the network, and mounts an empty /dev/shm and /tmp and a /proc of its own.
/// REQUIRES: it is the first process of its own namespaces of mounts and of processes.
Result<void> leave_this_host(const hosts::NetworkNamespace& network, unsigned shm_mebibytes) {
  return network.enter()
      .and_then(hosts::make_mounts_private)
      .and_then([&] { return hosts::mount_own_shm(shm_mebibytes); })
      .and_then(hosts::mount_own_tmp)
      .and_then(hosts::mount_own_proc);
}

[[noreturn]] void give_up(const std::string& who, const Error& error) {
  std::fprintf(stderr, "sft_demo: %s: %s\n", who.c_str(), error.message.c_str());
  _exit(1);
}

[[noreturn]] void run_role(const Role& role) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  prctl(PR_SET_NAME, role.name.c_str());  // shown by ps and top
  // The demo orders the end, so that nodes can take their leave. The signal ends only the daemon.
  signal(SIGTERM, [](int) {});
  hosts::block_only({});
  const Result<void> done = role.run();
  if (!done) give_up(role.name, done.error());
  _exit(0);
}

/// The first process of a host. noexcept: an exception must not reach the stack that was copied from the
/// demo.
[[noreturn]] void run_host(const HostSettings& settings, const std::vector<Role>& roles) noexcept {
  setsid();  // Ctrl-C is for the demo, which then ends its hosts
  hosts::block_only({SIGCHLD, SIGTERM});
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  prctl(PR_SET_CHILD_SUBREAPER, 1);
  if (settings.network != nullptr) {
    const Result<void> left = leave_this_host(*settings.network, settings.shm_mebibytes);
    if (!left) give_up("host", left.error());
  }
  hosts::close_descriptors_except({});
  std::vector<pid_t> running;
  for (const Role& role : roles) {
    running.push_back(fork());
    if (running.back() == 0) run_role(role);
  }
  // Adopted processes end, too: a daemon leaves one behind when it starts.
  int number = 0;
  bool failed = false;
  sigset_t awaited;
  sigemptyset(&awaited);
  sigaddset(&awaited, SIGCHLD);
  sigaddset(&awaited, SIGTERM);
  while (!running.empty() && !failed && sigwait(&awaited, &number) == 0 && number != SIGTERM) {
    int status = 0;
    for (pid_t gone = 0; (gone = waitpid(-1, &status, WNOHANG)) > 0;)
      failed = failed || (std::erase(running, gone) != 0 && status != 0);
  }
  hosts::end_children(patience_with_children);
  _exit(0);
}

}  // namespace

Result<void> become_root() {
  // The network of this machine does not belong to the new root: a process that leaves it cannot come back.
  return geteuid() == 0 ? Result<void>() : hosts::enter_user_namespace(CLONE_NEWNET);
}

Result<void> try_isolation() {
  return hosts::in_child([](int) -> Result<void> {
    hosts::program_directory();
    if (Result<void> root = become_root(); !root) return root;
    const auto network = hosts::EmulatedNetwork::create(1);
    if (!network) return tl::unexpected(network.error());
    if (unshare(CLONE_NEWNS | CLONE_NEWPID) != 0) return hosts::system_error("namespaces cannot be made");
    return hosts::in_child([&](int) { return leave_this_host(network->host(0), 1); });
  });
}

Result<pid_t> start_host(const HostSettings& settings, const std::vector<Role>& roles) {
  hosts::program_directory();  // while /proc is that of the machine
  const pid_t first_process = fork_into(settings.network == nullptr ? 0 : CLONE_NEWNS | CLONE_NEWPID);
  if (first_process < 0) return hosts::system_error("a host cannot be started");
  if (first_process == 0) run_host(settings, roles);
  return first_process;
}

}  // namespace sft::demo
