#include "core/platform/process_limits.h"

#include <dirent.h>
#include <fcntl.h>
#include <linux/futex.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/select.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <climits>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "core/platform/file_descriptor.h"
#include "core/platform/task_limits.h"

namespace sft::core {

namespace {

template <class Resource>
std::string limit_of(Resource resource) {
  rlimit limit{};
  if (getrlimit(resource, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return "any number";
  return std::to_string(limit.rlim_cur);
}

/// Takes the `count` free descriptors with the lowest numbers. If it returns fewer, errno contains the
/// reason.
std::vector<FileDescriptor> take_descriptors(std::size_t count) {
  std::vector<FileDescriptor> taken;
  taken.reserve(count);
  taken.emplace_back(::open("/", O_PATH | O_CLOEXEC));  // which is there in a sandbox, too
  while (taken.back() && taken.size() < count)
    taken.emplace_back(::fcntl(taken.front().get(), F_DUPFD_CLOEXEC, 0));
  if (!taken.back()) taken.pop_back();
  return taken;
}

Result<void> check_descriptors(std::size_t count) {
  if (take_descriptors(count).size() == count) return {};
  return fail(Errc::limit_exceeded,
              std::string("there are too few file descriptors (") + std::strerror(errno) +
                  "); this process may have " + limit_of(RLIMIT_NOFILE) +
                  " of them: raise the limit RLIMIT_NOFILE (ulimit -n, or LimitNOFILE= of its service)");
}

/// Threads that wait until this object is destroyed. They use no memory except for small stacks.
class SpareThreads {
 public:
  explicit SpareThreads(std::size_t count) {
    threads_.reserve(count);
    pthread_attr_t small;
    ::pthread_attr_init(&small);
    ::pthread_attr_setstacksize(&small, stack_bytes);
    while (error_ == 0 && threads_.size() < count) {
      pthread_t thread{};
      error_ = ::pthread_create(&thread, &small, &SpareThreads::wait, &may_end_);
      if (error_ == 0) threads_.push_back(thread);
    }
    ::pthread_attr_destroy(&small);
  }
  SpareThreads(const SpareThreads&) = delete;
  SpareThreads& operator=(const SpareThreads&) = delete;
  ~SpareThreads() {
    may_end_.store(1);
    ::syscall(SYS_futex, &may_end_, FUTEX_WAKE_PRIVATE, INT_MAX, nullptr, nullptr, 0);
    for (const pthread_t thread : threads_) ::pthread_join(thread, nullptr);
  }

  int error() const { return error_; }  ///< the error number if a thread could not be started, or 0

 private:
  static constexpr std::size_t stack_bytes = 128 * 1024;

  static void* wait(void* word) {
    auto& may_end = *static_cast<std::atomic<std::uint32_t>*>(word);
    while (may_end.load() == 0) ::syscall(SYS_futex, &may_end, FUTEX_WAIT_PRIVATE, 0, nullptr, nullptr, 0);
    return nullptr;
  }

  std::atomic<std::uint32_t> may_end_{0};
  std::vector<pthread_t> threads_;
  int error_ = 0;
};

/// Checks that the process may still reserve the maximum amount of address space that `threads` threads
/// need. In addition to its stack, each thread that allocates memory gets a separate arena of the GNU C
/// library, which reserves the whole arena at once (mallopt(3), HEAP_MAX_SIZE in the source of the
/// library).
Result<void> check_addresses(std::size_t threads) {
  constexpr std::size_t arena = std::size_t{64} << 20;
  constexpr std::size_t besides = std::size_t{64} << 20;
  pthread_attr_t usual;
  std::size_t stack = 0;
  ::pthread_attr_init(&usual);
  ::pthread_attr_getstacksize(&usual, &stack);
  ::pthread_attr_destroy(&usual);
  const std::size_t bytes = threads * (stack + arena) + besides;
  void* const spare = ::mmap(nullptr, bytes, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (spare == MAP_FAILED)
    return fail(Errc::limit_exceeded,
                "there is too little address space: " + std::to_string(bytes >> 20) +
                    " MiB more are needed, and this process may have " + limit_of(RLIMIT_AS) +
                    " bytes in all: raise the limit RLIMIT_AS (ulimit -v, or LimitAS= of "
                    "its service)");
  ::munmap(spare, bytes);
  return {};
}

bool is_far_from_the_limits(std::size_t threads) {
  constexpr std::uint64_t that_others_may_start = 200;
  rlimit of_user{};
  if (::getrlimit(RLIMIT_NPROC, &of_user) != 0) return false;
  return threads_left(of_user.rlim_cur).value_or(0) >= threads + that_others_may_start;
}

/// Checks that `count` threads can be started. Threads are started for the check only if a limit is near,
/// because starting them costs more than a millisecond: the threads keep the processor busy for a while
/// after their end.
Result<void> check_threads(std::size_t count) {
  if (is_far_from_the_limits(count)) return {};
  const SpareThreads spare(count);
  if (spare.error() == 0) return {};
  return fail(Errc::limit_exceeded, std::string("no more threads can be started (") +
                                        std::strerror(spare.error()) + "); this user may have " +
                                        limit_of(RLIMIT_NPROC) +
                                        ": raise the limit RLIMIT_NPROC (ulimit -u), or that of the service "
                                        "(TasksMax=)");
}

}  // namespace

Result<void> check_room_for(std::size_t descriptors, std::size_t threads) {
  if (Result<void> enough = check_descriptors(descriptors); !enough) return enough;
  if (Result<void> enough = check_addresses(threads); !enough) return enough;
  return check_threads(threads);
}

Result<void> check_room_for_select(std::size_t descriptors) {
  const std::vector<FileDescriptor> lowest = take_descriptors(descriptors);
  const bool fits = lowest.size() == descriptors && lowest.back().get() < FD_SETSIZE;
  if (fits) return {};
  return fail(Errc::limit_exceeded,
              "Cyclone DDS needs " + std::to_string(descriptors) + " file descriptors with numbers below " +
                  std::to_string(FD_SETSIZE) +
                  ", and this program has others open there: open nodes before so many files, or close some");
}

bool has_no_open_files() {
  const std::unique_ptr<DIR, int (*)(DIR*)> files(::opendir("/proc/self/fd"), &::closedir);
  if (!files) return false;
  while (const dirent* const entry = ::readdir(files.get())) {
    const int number = std::atoi(entry->d_name);  // 0 for "." and ".."
    if (number > STDERR_FILENO && number != ::dirfd(files.get())) return false;
  }
  return true;
}

Result<void> raise_inherited_limits(std::size_t descriptors) {
  for (const auto resource :
       {RLIMIT_NOFILE, RLIMIT_CPU, RLIMIT_FSIZE, RLIMIT_AS, RLIMIT_DATA, RLIMIT_RTTIME}) {
    rlimit limit{};
    if (::getrlimit(resource, &limit) != 0) continue;
    limit.rlim_cur = limit.rlim_max;
    ::setrlimit(resource, &limit);
  }
  if (::getpriority(PRIO_PROCESS, 0) > 0) ::setpriority(PRIO_PROCESS, 0, 0);
  rlimit files{}, time{};
  if (::getrlimit(RLIMIT_NOFILE, &files) == 0 && files.rlim_cur < descriptors)
    return fail(Errc::limit_exceeded,
                "it may have " + limit_of(RLIMIT_NOFILE) + " file descriptors, and needs " +
                    std::to_string(descriptors) +
                    ": raise the hard limit RLIMIT_NOFILE (ulimit -H -n, or LimitNOFILE= of a service)");
  if (::getrlimit(RLIMIT_CPU, &time) == 0 && time.rlim_cur != RLIM_INFINITY)
    return fail(Errc::limit_exceeded, "the system would end it after " + limit_of(RLIMIT_CPU) +
                                          " s of processor time: raise the hard limit RLIMIT_CPU (ulimit -H "
                                          "-t, or LimitCPU= of a service)");
  return {};
}

Result<void> check_file_size(std::size_t bytes) {
  rlimit limit{};
  if (::getrlimit(RLIMIT_FSIZE, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY || limit.rlim_cur >= bytes)
    return {};
  return fail(Errc::limit_exceeded, "this process may write files of at most " + limit_of(RLIMIT_FSIZE) +
                                        " bytes, and one of " + std::to_string(bytes) +
                                        " bytes is needed: raise the limit RLIMIT_FSIZE (ulimit -f, or "
                                        "LimitFSIZE= of its service)");
}

}  // namespace sft::core
