#include "core/platform/doorbell.h"

#include <fcntl.h>
#include <linux/futex.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <charconv>
#include <cstring>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <system_error>

#include "core/platform/process_limits.h"
#include "core/platform/random_id.h"
#include "core/sync/spin.h"

namespace sft::core {

namespace {

constexpr const char* page_directory = "/dev/shm";
constexpr std::string_view prefix = "sft_bell_";
constexpr std::string_view no_directory = "/memfd:";  // the beginning of links to files that never had a path
constexpr std::size_t page_bytes = DoorbellPage::slots * sizeof(Doorbell);

Doorbell* map(int fd) {
  const int flags = fd < 0 ? MAP_PRIVATE | MAP_ANONYMOUS : MAP_SHARED;
  void* memory = mmap(nullptr, page_bytes, PROT_READ | PROT_WRITE, flags, fd, 0);
  return memory == MAP_FAILED ? nullptr : static_cast<Doorbell*>(memory);
}

bool is_whole(int fd) {
  struct stat status {};
  return fstat(fd, &status) == 0 && static_cast<std::size_t>(status.st_size) >= page_bytes;
}

/// Creates a locked file of a page's size. Returns its descriptor, or -1 if that fails.
int create_file(const std::string& path) {
  if (!check_file_size(page_bytes)) return -1;
  const int fd = open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0660);
  if (fd < 0) return -1;
  // posix_fallocate() is used because without it, a write to a page that a full tmpfs cannot allocate would
  // later cause a SIGBUS. fchmod() is used because other members of our group must be able to ring,
  // whatever the umask is.
  if (flock(fd, LOCK_EX | LOCK_NB) == 0 && fchmod(fd, 0660) == 0 && posix_fallocate(fd, 0, page_bytes) == 0)
    return fd;
  unlink(path.c_str());
  close(fd);
  return -1;
}

/// Creates a locked file of a page's size without a path, which needs no space in /dev/shm. Returns its
/// descriptor, or -1 if that fails.
int create_nameless_file(std::uint64_t id) {
  if (!check_file_size(page_bytes)) return -1;
  const int fd = memfd_create((std::string(prefix) + in_hex(id)).c_str(), MFD_CLOEXEC);
  if (fd < 0) return -1;
  if (posix_fallocate(fd, 0, page_bytes) == 0) return fd;
  close(fd);
  return -1;
}

bool is_number(const char* text) {
  return *text != '\0' && std::strspn(text, "0123456789") == std::strlen(text);
}

/// Returns the id of the page to which the link leads. Returns nothing if the link does not lead to a page,
/// or if the page still has a path.
std::optional<std::uint64_t> nameless_id(const std::filesystem::path& link) {
  std::error_code ignored;
  const std::string target = std::filesystem::read_symlink(link, ignored);
  const std::string named = std::string(page_directory) + "/" + std::string(prefix);
  const std::string never_named = std::string(no_directory) + std::string(prefix);
  const bool is_page = target.starts_with(named) || target.starts_with(never_named);
  if (!is_page || !target.ends_with(" (deleted)")) return std::nullopt;
  const char* const digits = target.data() + target.find(prefix) + prefix.size();
  std::uint64_t id = 0;
  const auto [end, error] = std::from_chars(digits, target.data() + target.size(), id, 16);
  return error == std::errc{} && *end == ' ' ? std::optional(id) : std::nullopt;
}

void note_nameless_pages(const std::filesystem::path& process, std::map<std::uint64_t, std::string>& pages) {
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(process / "fd", ignored)) {
    if (const auto id = nameless_id(entry.path())) pages.emplace(*id, entry.path());
  }
}

}  // namespace

void Doorbell::wake() noexcept {
  // All threads are woken: two threads of a process may wait on one word, and each checks its own condition.
  syscall(SYS_futex, &rings, FUTEX_WAKE, 0x7fffffff, nullptr, nullptr, 0);
}

bool Doorbell::spin(std::uint32_t seen, std::chrono::steady_clock::time_point until) const noexcept {
  return core::spin(until, [&] { return rung(seen); });
}

void Doorbell::sleep(std::uint32_t seen, std::chrono::steady_clock::time_point deadline) noexcept {
  const auto ns = std::chrono::duration_cast<std::chrono::nanoseconds>(deadline.time_since_epoch()).count();
  timespec until{};
  until.tv_sec = ns / 1'000'000'000;
  until.tv_nsec = ns % 1'000'000'000;
  const bool forever = deadline == std::chrono::steady_clock::time_point::max();
  // The bitset variant takes an absolute time of CLOCK_MONOTONIC.
  syscall(SYS_futex, &rings, FUTEX_WAIT_BITSET, seen, forever ? nullptr : &until, nullptr,
          FUTEX_BITSET_MATCH_ANY);
}

std::string DoorbellPage::path_of(std::uint64_t id) {
  return std::string(page_directory) + "/" + std::string(prefix) + in_hex(id);
}

std::unique_ptr<DoorbellPage> DoorbellPage::create() {
  const std::uint64_t id = random_id();
  const std::string path = path_of(id);
  int fd = create_file(path);
  if (fd < 0) fd = create_nameless_file(id);
  if (fd >= 0) {
    if (Doorbell* bells = map(fd)) return std::unique_ptr<DoorbellPage>(new DoorbellPage(id, bells, fd));
    unlink(path.c_str());
    close(fd);
  }
  Doorbell* bells = map(-1);
  if (bells == nullptr) throw std::bad_alloc();
  return std::unique_ptr<DoorbellPage>(new DoorbellPage(0, bells, -1));
}

Result<std::unique_ptr<DoorbellPage>> DoorbellPage::open(std::uint64_t id, const TrustedAccounts& accounts) {
  const std::string path = path_of(id);
  const auto file = open_trusted_file(path, O_RDWR, accounts);
  if (!file) return tl::unexpected(file.error());
  return share(id, *file);
}

std::map<std::uint64_t, std::string> DoorbellPage::nameless_pages() {
  std::map<std::uint64_t, std::string> pages;
  std::error_code ignored;
  for (const auto& process : std::filesystem::directory_iterator("/proc", ignored)) {
    struct stat status {};
    if (!is_number(process.path().filename().c_str()) || stat(process.path().c_str(), &status) != 0) continue;
    if (status.st_uid == geteuid()) note_nameless_pages(process.path(), pages);
  }
  return pages;
}

Result<std::unique_ptr<DoorbellPage>> DoorbellPage::open_nameless(std::uint64_t id, const std::string& link) {
  const FileDescriptor file(::open(link.c_str(), O_RDWR | O_CLOEXEC | O_NONBLOCK));
  struct stat opened {};
  const bool is_page = file && nameless_id(link) == id && fstat(file.get(), &opened) == 0 &&
                       S_ISREG(opened.st_mode) && opened.st_uid == geteuid();
  if (!is_page) return fail(Errc::unavailable, path_of(id) + " is not open in any process any more");
  return share(id, file);
}

Result<std::unique_ptr<DoorbellPage>> DoorbellPage::share(std::uint64_t id, const FileDescriptor& file) {
  // With a file shorter than a page, every ring would cause a SIGBUS.
  Doorbell* bells = is_whole(file.get()) ? map(file.get()) : nullptr;
  if (bells == nullptr) return fail(Errc::malformed, path_of(id) + ": not a doorbell page");
  return std::unique_ptr<DoorbellPage>(new DoorbellPage(id, bells, -1));
}

std::size_t DoorbellPage::sweep() noexcept {
  std::size_t removed = 0;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(page_directory, ignored)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with(prefix)) continue;
    const auto file = open_trusted_file(entry.path(), O_RDWR, {.everybody = true});
    // A new page is empty until its owner has locked the file. So empty pages must not be removed.
    if (!file || !is_whole(file->get())) continue;
    if (flock(file->get(), LOCK_EX | LOCK_NB) == 0 && unlink(entry.path().c_str()) == 0) ++removed;
  }
  return removed;
}

DoorbellPage::~DoorbellPage() {
  munmap(static_cast<void*>(bells_), page_bytes);
  if (fd_ < 0) return;
  unlink(path_of(id_).c_str());
  close(fd_);
}

}  // namespace sft::core
