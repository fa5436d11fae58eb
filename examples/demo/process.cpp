#include "examples/demo/process.h"

#include <fmt/format.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <string>

#include "examples/demo/descriptor.h"

namespace sft::demo {

Result<void> in_child(const std::function<Result<void>()>& body) {
  int ends[2];
  if (pipe(ends) != 0) return fail(Errc::system, fmt::format("pipe: {}", std::strerror(errno)));
  const Descriptor from_child(ends[0]);
  Descriptor to_parent(ends[1]);
  const pid_t child = fork();
  if (child < 0) return fail(Errc::system, fmt::format("fork: {}", std::strerror(errno)));
  if (child == 0) {
    const Result<void> result = body();
    if (!result) dprintf(to_parent.get(), "%s", result.error().message.c_str());
    _exit(result ? 0 : 1);
  }
  to_parent = Descriptor();
  char text[512];
  ssize_t bytes = 0;
  do {
    bytes = read(from_child.get(), text, sizeof text);
  } while (bytes < 0 && errno == EINTR);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) continue;
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return {};
  return fail(Errc::system, std::string(text, static_cast<std::size_t>(std::max<ssize_t>(bytes, 0))));
}

void close_descriptors_except(std::vector<int> kept) {
  std::sort(kept.begin(), kept.end());
  unsigned next = STDERR_FILENO + 1;
  for (const int descriptor : kept) {
    const auto number = static_cast<unsigned>(descriptor);
    if (number < next) continue;
    if (number > next) close_range(next, number - 1, 0);
    next = number + 1;
  }
  close_range(next, ~0U, 0);
}

std::vector<pid_t> children() {
  std::vector<pid_t> pids;
  std::ifstream list("/proc/thread-self/children");
  for (pid_t pid = 0; list >> pid;) pids.push_back(pid);
  return pids;
}

void end_children(std::chrono::milliseconds patience) {
  sigset_t child_ended;
  sigemptyset(&child_ended);
  sigaddset(&child_ended, SIGCHLD);
  sigprocmask(SIG_BLOCK, &child_ended, nullptr);
  for (const pid_t pid : children()) kill(pid, SIGTERM);

  const auto deadline = std::chrono::steady_clock::now() + patience;
  for (;;) {
    pid_t reaped = 0;
    while ((reaped = waitpid(-1, nullptr, WNOHANG)) > 0) continue;
    if (reaped < 0 && errno == ECHILD) return;
    const auto left = deadline - std::chrono::steady_clock::now();
    if (left <= left.zero()) break;
    const auto nanoseconds = std::chrono::duration_cast<std::chrono::nanoseconds>(left).count();
    const timespec wait{.tv_sec = nanoseconds / 1'000'000'000, .tv_nsec = nanoseconds % 1'000'000'000};
    sigtimedwait(&child_ended, nullptr, &wait);
  }
  // What a killed process leaves behind is adopted, and killed in turn.
  do {
    for (const pid_t pid : children()) kill(pid, SIGKILL);
  } while (waitpid(-1, nullptr, 0) > 0 || errno == EINTR);
}

}  // namespace sft::demo
