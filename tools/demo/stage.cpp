#include "tools/demo/stage.h"

#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <random>

#include "tools/hosts/child_process.h"
#include "tools/hosts/own_host.h"
#include "tools/hosts/system_error.h"

namespace sft::demo {

namespace {

using std::chrono::milliseconds;

constexpr milliseconds timeout_with_daemons{2'000};
// The time in which the processes of a host must end: nodes close, and daemons end.
constexpr milliseconds timeout_with_hosts{8'000};
// The size of /dev/shm on a host, on which the memory of its daemon depends. The host of the publisher also
// stores some samples of 6 MB.
constexpr unsigned shared_memory_mib = 256, publishers_shared_memory_mib = 1024;
constexpr std::size_t publishers_host = subscriber_roles.size() - 1;

struct Role {
  RolePlan plan;
  void (*run)(const RolePlan&, Channel&);
};

/// Returns the roles on host number `number`. The subscriber of the host is the first of them.
std::vector<Role> roles_on(std::size_t number, bool real_hosts, std::uint32_t domain,
                           const RunOptions& options) {
  const SubscriberRole& role = subscriber_roles[number];
  const bool remote = number != publishers_host;
  RolePlan subscriber{
      .name = role.name, .domain = domain, .max_rate_hz = role.max_rate_hz, .options = options};
  // The interface by which the subscriber receives its samples.
  if (real_hosts) subscriber.interface = remote ? hosts::host_interface : "lo";
  if (remote && !real_hosts) subscriber.transport = TransportChoice::udp;
  std::vector<Role> roles{{subscriber, role.run}};
  if (!remote) roles.push_back({{.name = "lidar", .domain = domain, .options = options}, run_publisher});
  return roles;
}

/// Moves the calling process into the network and mounts an empty /dev/shm and /tmp that only it and its
/// children see. Its next child becomes the first process of a new process namespace. When that child ends,
/// the kernel ends all processes in the namespace.
Result<void> leave_this_host(const hosts::NetworkNamespace& network, unsigned memory_mib) {
  hosts::program_directory();
  return network.enter()
      .and_then([] {
        return hosts::checked(unshare(CLONE_NEWNS | CLONE_NEWPID) == 0, "namespaces cannot be made");
      })
      .and_then(hosts::make_mounts_private)
      .and_then([&] { return hosts::mount_own_shm(memory_mib); })
      .and_then(hosts::mount_own_tmp);
}

/// Gets the rights to make hosts, which only root has. Any other user becomes root of a user namespace, if
/// the system allows it. The new root has no rights in the network of this machine, so a process that
/// leaves that network cannot return. REQUIRES: the process has one thread.
Result<void> become_root() {
  return geteuid() == 0 ? Result<void>() : hosts::enter_user_namespace(CLONE_NEWNET);
}

/// Tries in a child process whether hosts can be made. Returns an error with the reason if they cannot be
/// made.
Result<void> try_isolation() {
  return hosts::in_child([](int) -> Result<void> {
    if (Result<void> root = become_root(); !root) return root;
    const auto network = hosts::EmulatedNetwork::create(1);
    if (!network) return tl::unexpected(network.error());
    return leave_this_host(network->host(0), shared_memory_mib).and_then([] {
      return hosts::in_child([](int) { return hosts::mount_own_proc(); });
    });
  });
}

[[noreturn]] void give_up(std::vector<Channel>& channels, const Error& error) {
  for (Channel& channel : channels) refuse(channel, error);
  _exit(1);
}

[[noreturn]] void run_role(const Role& role, Channel& channel) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  prctl(PR_SET_NAME, role.plan.name.c_str());  // shown by ps and top
  hosts::block_only({});
  hosts::close_descriptors_except({channel.descriptor()});
  role.run(role.plan, channel);
  _exit(0);
}

/// The first process of a host. Starts the roles and waits until they have ended, or until it receives a
/// signal to end.
[[noreturn]] void look_after_roles(const std::vector<Role>& roles, std::vector<Channel>& channels) {
  std::vector<pid_t> running;
  for (std::size_t i = 0; i < roles.size(); ++i) {
    const pid_t role = fork();
    if (role == 0) run_role(roles[i], channels[i]);
    if (role > 0) running.push_back(role);
  }
  // Each role now has its own copy of its channel. If a role could not be started, its channel is closed at
  // the side of the demo.
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

/// Runs the roles on this machine, or in namespaces if `network` is not null. The function is noexcept,
/// because an exception must not unwind the stack that fork() has copied from the demo.
[[noreturn]] void run_host(const hosts::NetworkNamespace* network, unsigned memory_mib,
                           const std::vector<Role>& roles, std::vector<Channel>& channels) noexcept {
  setsid();  // Ctrl-C must reach only the demo, which then ends its hosts
  hosts::block_only({SIGCHLD, SIGTERM});
  std::vector<int> kept;
  for (const Channel& channel : channels) kept.push_back(channel.descriptor());
  if (network != nullptr) kept.push_back(network->descriptor());
  hosts::close_descriptors_except(kept);
  if (network == nullptr) {
    // An sftd that a role starts becomes a child of this process.
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    prctl(PR_SET_CHILD_SUBREAPER, 1);
    look_after_roles(roles, channels);
  }
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (const Result<void> left = leave_this_host(*network, memory_mib); !left) give_up(channels, left.error());
  // Only a child enters the new process namespace, as its first process. This process stays outside and
  // waits.
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

}  // namespace

Result<std::unique_ptr<Stage>> Stage::set_up(const RunOptions& options) {
  std::unique_ptr<Stage> stage(new Stage);
  if (const Result<void> possible = try_isolation(); possible) {
    if (const Result<void> root = become_root(); !root) return tl::unexpected(root.error());
    auto network = hosts::EmulatedNetwork::create(subscriber_roles.size());
    if (!network) return tl::unexpected(network.error());
    stage->network_ = std::move(*network);
  } else {
    stage->why_not_ = possible.error().message;
  }
  // Other programs of this machine may use the default domain. They rarely use one of the upper domains.
  std::random_device random;
  const std::uint32_t domain =
      stage->real_hosts() ? 0 : std::uniform_int_distribution<std::uint32_t>(100, 200)(random);
  for (std::size_t i = 0; i < subscriber_roles.size(); ++i) {
    if (const Result<void> started = stage->start_host(i, domain, options); !started)
      return tl::unexpected(started.error());
  }
  return stage;
}

Result<void> Stage::start_host(std::size_t number, std::uint32_t domain, const RunOptions& options) {
  const std::vector<Role> roles = roles_on(number, real_hosts(), domain, options);
  std::vector<Channel> theirs;
  for (std::size_t i = 0; i < roles.size(); ++i) {
    Result<std::pair<Channel, Channel>> ends = Channel::make_pair();
    if (!ends) return tl::unexpected(ends.error());
    channels_.push_back(std::move(ends->first));
    theirs.push_back(std::move(ends->second));
  }
  const pid_t first_process = fork();
  if (first_process < 0) return hosts::system_error("fork");
  if (first_process == 0)
    run_host(real_hosts() ? &network_->host(number) : nullptr,
             number == publishers_host ? publishers_shared_memory_mib : shared_memory_mib, roles, theirs);
  first_processes_.push_back(first_process);
  return {};
}

/// All roles end at the same time, when their channels are closed.
Stage::~Stage() {
  channels_.clear();
  for (const pid_t host : first_processes_) {
    // The call is made by number, since glibc 2.36 declares pidfd_open() for C only.
    const core::FileDescriptor process(static_cast<int>(syscall(SYS_pidfd_open, host, 0)));
    pollfd ended{.fd = process.get(), .events = POLLIN, .revents = 0};
    int result = 0;
    do {
      result = poll(&ended, 1, static_cast<int>(timeout_with_hosts.count()));
    } while (result < 0 && errno == EINTR);
    if (result <= 0) kill(host, SIGKILL);
    hosts::reap(host);
  }
}

}  // namespace sft::demo
