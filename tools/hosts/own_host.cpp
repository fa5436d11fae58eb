#include "tools/hosts/own_host.h"

#include <fcntl.h>
#include <sched.h>
#include <sys/mount.h>
#include <unistd.h>

#include "core/platform/file_descriptor.h"
#include "tools/hosts/system_error.h"

namespace sft::hosts {

namespace {

namespace fs = std::filesystem;

Result<void> write_line(const char* file, std::string_view line) {
  const core::FileDescriptor opened(open(file, O_WRONLY | O_CLOEXEC));
  const bool written =
      opened && write(opened.get(), line.data(), line.size()) == static_cast<ssize_t>(line.size());
  return checked(written, fmt::format("{} cannot be written", file));
}

Result<void> mount_memory(const char* where, unsigned mebibytes) {
  const std::string options = fmt::format("mode=1777,size={}m", mebibytes);
  return checked(mount("tmpfs", where, "tmpfs", MS_NOSUID | MS_NODEV, options.c_str()) == 0,
                 fmt::format("a private {} cannot be mounted", where));
}

constexpr unsigned tmp_mebibytes = 256;

}  // namespace

Result<void> enter_user_namespace(int other_kinds) {
  const uid_t user = geteuid();
  const gid_t group = getegid();
  return checked(unshare(CLONE_NEWUSER | other_kinds) == 0,
                 "that takes root, or a user namespace, which cannot be made")
      .and_then([] { return write_line("/proc/self/setgroups", "deny"); })
      .and_then([&] { return write_line("/proc/self/uid_map", fmt::format("0 {} 1", user)); })
      .and_then([&] { return write_line("/proc/self/gid_map", fmt::format("0 {} 1", group)); });
}

const fs::path& program_directory() {
  static const fs::path directory = [] {
    std::error_code error;
    return fs::read_symlink("/proc/self/exe", error).parent_path();
  }();
  return directory;
}

Result<void> make_mounts_private() {
  return checked(mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0,
                 "mounts cannot be made private");
}

Result<void> mount_own_shm(unsigned mebibytes) { return mount_memory("/dev/shm", mebibytes); }

Result<void> mount_own_tmp() {
  const fs::path& programs = program_directory();
  const fs::path kept = "/tmp" / *programs.lexically_relative("/tmp").begin();
  const core::FileDescriptor opened(open(kept.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC));
  if (Result<void> mounted = mount_memory("/tmp", tmp_mebibytes); !mounted) return mounted;
  std::error_code error;
  if (fs::exists(programs, error)) return {};
  fs::create_directories(kept, error);
  const std::string source = fmt::format("/proc/self/fd/{}", opened.get());
  return checked(mount(source.c_str(), kept.c_str(), nullptr, MS_BIND | MS_REC, nullptr) == 0,
                 fmt::format("{} cannot be mounted", kept.native()));
}

Result<void> mount_own_proc() {
  return checked(mount("proc", "/proc", "proc", MS_NOSUID | MS_NODEV | MS_NOEXEC, nullptr) == 0,
                 "a private /proc cannot be mounted");
}

}  // namespace sft::hosts
