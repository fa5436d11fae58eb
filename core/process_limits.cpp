#include "core/process_limits.h"

#include <fcntl.h>
#include <sys/resource.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include "core/file_descriptor.h"

namespace sft::core {

namespace {

template <class Resource>
std::string limit_of(Resource resource) {
  rlimit limit{};
  if (getrlimit(resource, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return "any number";
  return std::to_string(limit.rlim_cur);
}

Result<void> check_descriptors(std::size_t count) {
  std::vector<FileDescriptor> spare;
  for (std::size_t i = 0; i < count; ++i) {
    spare.emplace_back(::open("/dev/null", O_RDONLY | O_CLOEXEC));
    if (spare.back()) continue;
    return fail(Errc::limit_exceeded,
                std::string("there are too few file descriptors (") + std::strerror(errno) +
                    "); this process may have " + limit_of(RLIMIT_NOFILE) +
                    " of them: raise the limit RLIMIT_NOFILE (ulimit -n, or LimitNOFILE= of "
                    "its service)");
  }
  return {};
}

Result<void> check_threads(std::size_t count) {
  std::atomic<bool> all_began{false};
  std::vector<std::jthread> spare;
  Result<void> result;
  try {
    for (std::size_t i = 0; i < count; ++i) spare.emplace_back([&all_began] { all_began.wait(false); });
  } catch (const std::system_error& error) {
    result =
        fail(Errc::limit_exceeded, std::string("no more threads can be started (") + error.what() +
                                       "); this user may have " + limit_of(RLIMIT_NPROC) +
                                       ": raise the limit RLIMIT_NPROC (ulimit -u), or that of the service "
                                       "(TasksMax=)");
  }
  all_began = true;
  all_began.notify_all();
  return result;
}

}  // namespace

Result<void> check_room_for(std::size_t descriptors, std::size_t threads) {
  if (Result<void> enough = check_descriptors(descriptors); !enough) return enough;
  return check_threads(threads);
}

}  // namespace sft::core
