#include "tests/support/isolated_host.h"

#include <net/if.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/mount.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <stdexcept>

#include "tools/hosts/own_host.h"
#include "tools/hosts/system_error.h"

namespace sft::test {

namespace {

constexpr int own_namespaces = CLONE_NEWNS | CLONE_NEWNET | CLONE_NEWPID;
// sftd takes half of this memory and zeroes it. That takes long on a machine with little free memory.
constexpr unsigned shm_mebibytes = 320;

std::string refusal = "run_isolated was not called";

bool refuse(const Error& error) {
  refusal = "needs root or user namespaces: " + error.message;
  return false;
}

bool enter_namespaces() {
  if (unshare(own_namespaces) == 0) return true;
  const Result<void> entered = hosts::enter_user_namespace(own_namespaces);
  return entered || refuse(entered.error());
}

/// Brings the loopback interface up with multicast. Discovery uses multicast, and the host has no other
/// interface.
bool bring_loopback_up() {
  const int control = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  ifreq request{};
  std::strcpy(request.ifr_name, "lo");
  bool up = ioctl(control, SIOCGIFFLAGS, &request) == 0;
  request.ifr_flags = static_cast<short>(request.ifr_flags | IFF_UP | IFF_MULTICAST);
  up = up && ioctl(control, SIOCSIFFLAGS, &request) == 0;
  close(control);
  return up;
}

bool set_up() {
  const Result<void> done = hosts::checked(bring_loopback_up(), "loopback")
                                .and_then(hosts::make_mounts_private)
                                .and_then(hosts::mount_own_proc)
                                .and_then(mount_own_memory);
  if (!done) return refuse(done.error());
  refusal.clear();
  return true;
}

int exit_code(int status) { return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status); }

/// Becomes the first process of the new host, which reaps orphans. All processes of the host end with this
/// process.
[[noreturn]] void be_init(const std::function<int()>& run) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  set_up();
  const pid_t program = fork();
  if (program == 0) std::exit(run());
  int status = 0;
  for (pid_t dead = 0; dead != program;) dead = wait(&status);
  _exit(exit_code(status));
}

}  // namespace

const std::string& isolation_refusal() { return refusal; }

const std::string& program_directory() { return hosts::program_directory().native(); }

Result<void> mount_own_shm() { return hosts::mount_own_shm(shm_mebibytes); }

Result<void> mount_own_memory() { return mount_own_shm().and_then(hosts::mount_own_tmp); }

int run_isolated(const std::function<int()>& run) {
  program_directory();  // the first call must happen while /proc belongs to this process
  if (!enter_namespaces()) return run();
  std::fflush(nullptr);
  const pid_t init = fork();
  if (init < 0) return run();
  if (init == 0) be_init(run);
  int status = 0;
  waitpid(init, &status, 0);
  _exit(exit_code(status));  // not exit(), because the child has already run its handlers
}

ShmOfSize::ShmOfSize(unsigned mebibytes) {
  const Result<void> mounted = hosts::mount_own_shm(mebibytes);
  if (!mounted) throw std::runtime_error(mounted.error().message);
}

ShmOfSize::~ShmOfSize() { umount2("/dev/shm", MNT_DETACH); }

}  // namespace sft::test
