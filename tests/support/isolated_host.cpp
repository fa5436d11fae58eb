#include "tests/support/isolated_host.h"

#include <fcntl.h>
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
#include <filesystem>
#include <fstream>

namespace sft::test {

namespace {

constexpr int own_namespaces = CLONE_NEWNS | CLONE_NEWNET | CLONE_NEWPID;
// sftd zeroes what it takes, half of this; where the machine below has to find that memory first, it takes
// long.
constexpr const char* shm_size = "320m";

std::string refusal = "run_isolated was not called";

bool refuse(const char* what) {
  refusal = std::string("needs root or user namespaces: ") + what + ": " + std::strerror(errno);
  return false;
}

bool enter_namespaces() {
  if (unshare(own_namespaces) == 0) return true;
  const uid_t user = geteuid();
  const gid_t group = getegid();
  if (unshare(CLONE_NEWUSER | own_namespaces) != 0) return refuse("unshare");
  std::ofstream("/proc/self/setgroups") << "deny";
  std::ofstream("/proc/self/uid_map") << "0 " << user << " 1";
  std::ofstream("/proc/self/gid_map") << "0 " << group << " 1";
  return true;
}

bool mount_shm(const char* size) {
  return mount("tmpfs", "/dev/shm", "tmpfs", 0, (std::string("mode=1777,size=") + size).c_str()) == 0;
}

/// Discovery multicasts, and there is no interface but this one.
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
  if (!bring_loopback_up()) return refuse("loopback");
  if (mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0) return refuse("mount");
  if (mount("proc", "/proc", "proc", 0, nullptr) != 0) return refuse("mount /proc");
  if (!mount_own_memory()) return refuse("mount /dev/shm and /tmp");
  refusal.clear();
  return true;
}

int exit_code(int status) { return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status); }

/// Process 1 of the new host: buries orphans, and takes everything with it when the program ends.
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

const std::string& program_directory() {
  static const std::string directory = std::filesystem::read_symlink("/proc/self/exe").parent_path();
  return directory;
}

bool mount_own_shm() { return mount_shm(shm_size); }

/// The build may itself lie in /tmp: its programs are put into the new one at the same place.
bool mount_own_tmp() {
  const std::string& programs = program_directory();
  const int directory = open(programs.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC);
  if (mount("tmpfs", "/tmp", "tmpfs", 0, "mode=1777,size=256m") != 0) return false;
  if (access(programs.c_str(), F_OK) == 0) return true;
  std::filesystem::create_directories(programs);
  const std::string source = "/proc/self/fd/" + std::to_string(directory);
  return mount(source.c_str(), programs.c_str(), nullptr, MS_BIND, nullptr) == 0;
}

bool mount_own_memory() { return mount_own_shm() && mount_own_tmp(); }

int run_isolated(const std::function<int()>& run) {
  program_directory();  // while /proc is still the one of this process
  if (!enter_namespaces()) return run();
  std::fflush(nullptr);
  const pid_t init = fork();
  if (init < 0) return run();
  if (init == 0) be_init(run);
  int status = 0;
  waitpid(init, &status, 0);
  _exit(exit_code(status));  // what the program had to do at its end, it did there
}

ShmOfSize::ShmOfSize(const char* size) { mount_shm(size); }
ShmOfSize::~ShmOfSize() { umount2("/dev/shm", MNT_DETACH); }

}  // namespace sft::test
