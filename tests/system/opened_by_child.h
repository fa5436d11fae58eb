// Opens a node in a child process that lacks a resource.
#pragma once

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <functional>
#include <string>
#include <utility>

#include "tests/support/eventually.h"
#include "tests/system/fixture.h"

namespace sft::test {

/// The outcome of Node::open().
enum class Opened : std::uint8_t { node, limit_exceeded, other_error, leaked, crashed };

/// Returns the numbers of descriptors and threads of this process.
inline std::pair<std::size_t, std::size_t> in_use() {
  std::pair<std::size_t, std::size_t> counts;
  for (int fd = 0; fd < 1024; ++fd) counts.first += fcntl(fd, F_GETFD) >= 0 ? 1 : 0;
  struct stat tasks {};
  if (stat("/proc/self/task", &tasks) == 0) counts.second = tasks.st_nlink;
  return counts;
}

/// Opens a node in a child process in which `lack` is called first. The outcome is Opened::limit_exceeded
/// only if the error names `limit`.
inline Opened opened_by_child(const std::function<void()>& lack, const std::string& limit) {
  const pid_t child = fork();
  if (child == 0) {
    alarm(30);  // ends a child that hangs in the same way as a crash
    lack();
    const auto before = in_use();
    const auto node = Node::open(node_options(Way::udp, "short_of_all"));
    const bool descriptors_are_back = in_use().first == before.first;
    // The kernel lists a thread for a short time after it was joined.
    const auto all_are_back = [&] { return descriptors_are_back && in_use() == before; };
    if (!node && !eventually(all_are_back, std::chrono::seconds(1))) _exit(static_cast<int>(Opened::leaked));
    const bool is_limit = !node && node.error().code == Errc::limit_exceeded &&
                          node.error().message.find(limit) != std::string::npos;
    _exit(static_cast<int>(node ? Opened::node : is_limit ? Opened::limit_exceeded : Opened::other_error));
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? static_cast<Opened>(WEXITSTATUS(status)) : Opened::crashed;
}

}  // namespace sft::test
