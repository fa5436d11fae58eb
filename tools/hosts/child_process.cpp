#include "tools/hosts/child_process.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <string>

#include "core/platform/file_descriptor.h"
#include "tools/hosts/system_error.h"

namespace sft::hosts {

namespace {

sigset_t set_of(std::initializer_list<int> signals) {
  sigset_t set;
  sigemptyset(&set);
  for (const int signal : signals) sigaddset(&set, signal);
  return set;
}

std::string read_all(int descriptor) {
  std::string text;
  char part[1024];
  for (;;) {
    const ssize_t bytes = read(descriptor, part, sizeof part);
    if (bytes < 0 && errno == EINTR) continue;
    if (bytes <= 0) break;
    text.append(part, static_cast<std::size_t>(bytes));
  }
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text;
}

/// Returns the ids of the children of this process, including adopted ones.
std::vector<pid_t> children() {
  std::vector<pid_t> pids;
  std::ifstream list("/proc/thread-self/children");
  for (pid_t pid = 0; list >> pid;) pids.push_back(pid);
  return pids;
}

int status_of(pid_t child) {
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) continue;
  return status;
}

}  // namespace

Result<void> in_child(const std::function<Result<void>(int output)>& body) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return system_error("pipe");
  const core::FileDescriptor from_child(ends[0]);
  core::FileDescriptor to_parent(ends[1]);
  const pid_t child = fork();
  if (child < 0) return system_error("fork");
  if (child == 0) {
    const Result<void> result = body(to_parent.get());
    if (!result) dprintf(to_parent.get(), "%s", result.error().message.c_str());
    _exit(result ? 0 : 1);
  }
  to_parent = core::FileDescriptor();
  std::string output = read_all(from_child.get());
  const int status = status_of(child);
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return {};
  return fail(Errc::system, std::move(output));
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

void block_only(std::initializer_list<int> signals) {
  const sigset_t blocked = set_of(signals);
  sigprocmask(SIG_SETMASK, &blocked, nullptr);
}

void reap(pid_t child) { status_of(child); }

void end_children(std::chrono::milliseconds timeout) {
  const sigset_t child_ended = set_of({SIGCHLD});
  sigprocmask(SIG_BLOCK, &child_ended, nullptr);
  for (const pid_t pid : children()) kill(pid, SIGTERM);

  const auto deadline = std::chrono::steady_clock::now() + timeout;
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
  // The loop is needed because this process adopts the children of a killed process, and kills them in
  // turn.
  do {
    for (const pid_t pid : children()) kill(pid, SIGKILL);
  } while (waitpid(-1, nullptr, 0) > 0 || errno == EINTR);
}

}  // namespace sft::hosts
