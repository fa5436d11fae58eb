#include "examples/demo/isolation.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "examples/demo/process.h"

namespace sft::demo {

namespace {

namespace fs = std::filesystem;

Result<void> checked(int result, std::string_view what) {
  if (result == 0) return {};
  const Errc code = errno == EPERM || errno == EACCES ? Errc::no_permission : Errc::system;
  return fail(code, fmt::format("{}: {}", what, std::strerror(errno)));
}

Result<void> write_line(const char* file, std::string_view line) {
  const Descriptor opened(open(file, O_WRONLY | O_CLOEXEC));
  const bool written =
      opened && write(opened.get(), line.data(), line.size()) == static_cast<ssize_t>(line.size());
  return checked(written ? 0 : -1, fmt::format("{} cannot be written", file));
}

Result<void> mount_memory(const char* where, const std::string& options) {
  return checked(mount("tmpfs", where, "tmpfs", MS_NOSUID | MS_NODEV, options.c_str()),
                 fmt::format("a private {} cannot be mounted", where));
}

Result<void> keep_visible(const fs::path& directory, const Descriptor& opened) {
  std::error_code error;
  if (fs::exists(directory, error)) return {};
  fs::create_directories(directory, error);
  return checked(mount(fmt::format("/proc/self/fd/{}", opened.get()).c_str(), directory.c_str(), nullptr,
                       MS_BIND, nullptr),
                 fmt::format("{} cannot be mounted", directory.native()));
}

/// Hides the machine's /tmp and /dev/shm. The library looks for its daemon beside the program, which must
/// stay in sight where the project was built in one of them.
Result<void> mount_own_memory(unsigned shared_memory_mib) {
  std::error_code error;
  const fs::path directory = fs::read_symlink("/proc/self/exe", error).parent_path();
  const Descriptor opened(open(directory.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC));
  return mount_memory("/tmp", "mode=1777")
      .and_then(
          [&] { return mount_memory("/dev/shm", fmt::format("mode=1777,size={}m", shared_memory_mib)); })
      .and_then([&] { return keep_visible(directory, opened); });
}

}  // namespace

Result<void> leave_this_host(const HostSettings& settings) {
  return settings.network->enter()
      .and_then([] { return checked(unshare(CLONE_NEWNS | CLONE_NEWPID), "namespaces cannot be made"); })
      .and_then([] {
        // Else the mounts below would show up outside.
        return checked(mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr),
                       "mounts cannot be made private");
      })
      .and_then([&] { return mount_own_memory(settings.shared_memory_mib); });
}

Result<void> mount_own_proc() {
  return checked(mount("proc", "/proc", "proc", MS_NOSUID | MS_NODEV | MS_NOEXEC, nullptr),
                 "a private /proc cannot be mounted");
}

Result<void> become_root() {
  const uid_t user = geteuid();
  const gid_t group = getegid();
  if (user == 0) return {};
  // The network of this machine is not this root's: whoever leaves it cannot come back.
  return checked(unshare(CLONE_NEWUSER | CLONE_NEWNET),
                 "that takes root, or a user namespace, which cannot be made")
      .and_then([] { return write_line("/proc/self/setgroups", "deny"); })
      .and_then([&] { return write_line("/proc/self/uid_map", fmt::format("0 {} 1", user)); })
      .and_then([&] { return write_line("/proc/self/gid_map", fmt::format("0 {} 1", group)); });
}

Result<void> try_isolation() {
  return in_child([]() -> Result<void> {
    if (Result<void> root = become_root(); !root) return root;
    const Result<EmulatedNetwork> network = EmulatedNetwork::create(1);
    if (!network) return tl::unexpected(network.error());
    return leave_this_host({.network = &network->host(0)}).and_then([] { return in_child(mount_own_proc); });
  });
}

}  // namespace sft::demo
