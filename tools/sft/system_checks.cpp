#include "tools/sft/system_checks.h"

#include <fmt/format.h>
#include <net/if.h>
#include <pwd.h>
#include <sft/options.h>
#include <sys/ioctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <sys/timex.h>
#include <sys/utsname.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <cctype>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>

#include "tools/terminal/units.h"

namespace sft::tool {

namespace {

constexpr std::uint64_t mib = 1024 * 1024;
constexpr rlim_t files_wanted = 256;             // each interface and each topic takes some descriptors
constexpr std::uint64_t shm_least = 128 * mib;   // sftd does not start with less memory
constexpr std::uint64_t shm_wanted = 256 * mib;  // enough for samples of 16 MiB
constexpr std::uint64_t memlock_wanted = 8 * mib;

std::string limit_text(rlim_t limit) {
  return limit == RLIM_INFINITY ? "unlimited" : bytes_text(static_cast<double>(limit));
}

std::string user_name(uid_t user) {
  const passwd* entry = getpwuid(user);
  return entry == nullptr ? fmt::format("user {}", user) : entry->pw_name;
}

/// Returns the accounts that run an sftd on this host.
std::set<uid_t> users_of_daemons() {
  std::set<uid_t> users;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator("/proc", ignored)) {
    const std::string pid = entry.path().filename();
    if (pid.empty() || std::isdigit(static_cast<unsigned char>(pid.front())) == 0) continue;
    std::string name;
    std::getline(std::ifstream(entry.path() / "comm"), name);
    struct stat status {};
    if (name == "sftd" && stat(entry.path().c_str(), &status) == 0) users.insert(status.st_uid);
  }
  return users;
}

}  // namespace

Finding check_kernel() {
  utsname system{};
  uname(&system);
  int major = 0;
  int minor = 0;
  std::sscanf(system.release, "%d.%d", &major, &minor);
  const std::string text = fmt::format("Linux {}", system.release);
  if (major > 6 || (major == 6 && minor >= 1)) return {"kernel", Health::ok, text};
  return {"kernel", Health::error, text, "SFT needs Linux 6.1 or newer: update the kernel."};
}

Finding check_loopback() {
  ifreq loopback{};
  std::strcpy(loopback.ifr_name, "lo");
  const int probe = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  const bool is_there = ioctl(probe, SIOCGIFFLAGS, &loopback) == 0;
  close(probe);
  if (is_there && (loopback.ifr_flags & IFF_UP) != 0) return {"loopback", Health::ok, "it is up"};
  return {"loopback", Health::error, is_there ? "the interface lo is down" : "there is no interface lo",
          "Nodes of this host do not find each other: ip link set lo up."};
}

Finding check_memlock() {
  rlimit limit{};
  getrlimit(RLIMIT_MEMLOCK, &limit);
  const std::string text = "a process may lock " + limit_text(limit.rlim_cur);
  if (limit.rlim_cur >= memlock_wanted || geteuid() == 0) return {"memlock", Health::ok, text};
  return {"memlock", Health::warning, text,
          "The kernel may refuse io_uring: raise the limit (ulimit -l 65536, or LimitMEMLOCK=64M in the "
          "service)."};
}

/// Checks the size of the receive buffer that a socket gets. (The setting net.core.rmem_max cannot be read
/// instead, because a container hides it.)
Finding check_receive_buffers() {
  const int wanted = static_cast<int>(UdpSettings{}.receive_buffer_bytes);
  const int asked = wanted / 2;  // the kernel doubles the number
  const int probe = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (setsockopt(probe, SOL_SOCKET, SO_RCVBUFFORCE, &asked, sizeof asked) != 0)
    setsockopt(probe, SOL_SOCKET, SO_RCVBUF, &asked, sizeof asked);
  int granted = 0;
  socklen_t bytes = sizeof granted;
  getsockopt(probe, SOL_SOCKET, SO_RCVBUF, &granted, &bytes);
  close(probe);
  int most = 0;  // the limit for processes without the right to exceed it
  std::ifstream("/proc/sys/net/core/rmem_max") >> most;
  const std::string limit = most == 0 ? "" : fmt::format("; net.core.rmem_max is {}", most);
  const std::string text =
      fmt::format("a socket gets {} of {}{}", bytes_text(granted), bytes_text(wanted), limit);
  if (granted >= wanted) return {"buffers", Health::ok, text};
  return {"buffers", Health::warning, text,
          fmt::format("Large samples go by UDP in small parts: run sysctl -w net.core.rmem_max={}", asked)};
}

Finding check_open_files() {
  rlimit limit{};
  getrlimit(RLIMIT_NOFILE, &limit);
  const std::string text = fmt::format("a process may open {} files", limit.rlim_cur);
  if (limit.rlim_cur >= files_wanted) return {"files", Health::ok, text};
  return {"files", Health::warning, text,
          "Nodes may run out of descriptors: raise the limit (ulimit -n 1024)."};
}

Finding check_proc() {
  if (access("/proc/self/stat", R_OK) != 0) {
    return {"/proc", Health::error, "it is not mounted",
            "sftd does not start, and samples within this host go by UDP: mount -t proc proc /proc."};
  }
  if (access("/proc/1/comm", R_OK) == 0) return {"/proc", Health::ok, "it is mounted"};
  return {"/proc", Health::ok, "it hides the processes of other accounts; so their sftd does not show here"};
}

Finding check_tmp() {
  struct statvfs space {};
  const bool is_there = statvfs("/tmp", &space) == 0;
  if (is_there && access("/tmp", W_OK | X_OK) == 0 && (space.f_flag & ST_RDONLY) == 0)
    return {"/tmp", Health::ok, "programs can write there"};
  return {"/tmp", Health::error,
          is_there ? "this account may not write there, or it is read-only" : "it is not there",
          "sftd does not start, and samples within this host go by UDP: mount a tmpfs there, or chmod 1777 "
          "/tmp."};
}

/// Returns true if the directory is a mount of another kind than a tmpfs.
bool is_on_a_disk(const char* directory) {
  struct statfs system {};
  constexpr long tmpfs = 0x01021994, ramfs = static_cast<long>(0x858458f6);
  return statfs(directory, &system) == 0 && system.f_type != tmpfs && system.f_type != ramfs;
}

Finding check_dev_shm() {
  struct statvfs space {};
  if (statvfs("/dev/shm", &space) != 0) {
    return {"/dev/shm", Health::error, "it is not there",
            "Samples within this host go by UDP: mount a tmpfs of 512 MB there."};
  }
  if ((space.f_flag & ST_RDONLY) != 0 || access("/dev/shm", W_OK | X_OK) != 0) {
    return {"/dev/shm", Health::error, "this account may not write there, or it is read-only",
            "Samples within this host go by UDP: mount a tmpfs of 512 MB there, or chmod 1777 /dev/shm."};
  }
  if (is_on_a_disk("/dev/shm")) {
    return {"/dev/shm", Health::warning, "it is no tmpfs",
            "Samples go through the cache of a disk: mount a tmpfs of 512 MB there."};
  }
  const std::uint64_t total = std::uint64_t{space.f_blocks} * space.f_frsize;
  const std::uint64_t free = std::uint64_t{space.f_bavail} * space.f_frsize;
  const std::string text = fmt::format("{} of {} are free", bytes_text(static_cast<double>(free)),
                                       bytes_text(static_cast<double>(total)));
  // A running daemon has already taken the memory that it needs.
  const bool has_daemon = !users_of_daemons().empty();
  if (total >= shm_wanted && (has_daemon || free >= shm_least)) return {"/dev/shm", Health::ok, text};
  if (total >= shm_least && (has_daemon || free >= shm_least))
    return {"/dev/shm", Health::warning, text,
            fmt::format("Samples of 16 MiB do not fit: give /dev/shm {} MiB or more.", shm_wanted / mib)};
  return {"/dev/shm", Health::error, text,
          fmt::format(
              "sftd needs {} MiB: remount it (mount -o remount,size=512m /dev/shm; docker: --shm-size=512m).",
              shm_least / mib)};
}

Finding check_users() {
  const std::set<uid_t> users = users_of_daemons();
  const std::string self = user_name(geteuid());
  if (users.empty()) return {"users", Health::ok, fmt::format("this is {}; nobody runs sftd here", self)};
  std::string names;
  bool is_ours = false;
  struct stat run {};
  const bool has_run = stat("/run/sft", &run) == 0;
  for (const uid_t user : users) {
    names += (names.empty() ? "" : ", ") + user_name(user);
    is_ours = is_ours || user == geteuid() || user == 0 || (has_run && user == run.st_uid);
  }
  const std::string text = fmt::format("this is {}; sftd is run by {}", self, names);
  if (is_ours) return {"users", Health::ok, text};
  return {"users", Health::warning, text,
          "Programs of this account do not use that sftd unless NodeOptions::shm.daemon_users names its "
          "account."};
}

Finding check_clock() {
  timex clock{};
  const int state = adjtimex(&clock);
  if (state >= 0 && state != TIME_ERROR && (clock.status & STA_UNSYNC) == 0) {
    return {"clock", Health::ok,
            fmt::format("it is synchronised, to about {}",
                        duration_text(static_cast<double>(clock.esterror) * 1e-6))};
  }
  return {"clock", Health::warning, "the system says that it is not synchronised",
          "Lifespans and delays between hosts are wrong by the difference of clocks: run chrony or "
          "systemd-timesyncd."};
}

}  // namespace sft::tool
