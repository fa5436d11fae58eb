#include "tests/support/tool_process.h"

#include <fcntl.h>
#include <poll.h>
#include <pty.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>

#include "tests/support/isolated_host.h"

namespace sft::test {

namespace {

void close_now(int& descriptor) {
  if (descriptor >= 0) close(descriptor);
  descriptor = -1;
}

}  // namespace

ToolProcess::ToolProcess(std::vector<std::string> arguments, On on) {
  std::array<int, 2> in{-1, -1};
  std::array<int, 2> out{-1, -1};
  std::array<int, 2> err{-1, -1};
  if (pipe2(err.data(), O_CLOEXEC) != 0) return;
  if (on == On::terminal) {
    winsize size{.ws_row = 24, .ws_col = 80, .ws_xpixel = 0, .ws_ypixel = 0};
    if (openpty(&out[0], &out[1], nullptr, nullptr, &size) != 0) return;
    terminal_ = out[0];
  } else if (pipe2(out.data(), O_CLOEXEC) != 0 ||
             socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, in.data()) != 0) {
    return;
  }
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, on == On::terminal ? out[1] : in[0], STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, out[1], STDOUT_FILENO);
  if (on == On::full_disk)
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/full", O_WRONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, err[1], STDERR_FILENO);
  arguments.insert(arguments.begin(), program_directory() + "/sft");
  std::vector<char*> pointers;
  for (std::string& argument : arguments) pointers.push_back(argument.data());
  pointers.push_back(nullptr);
  if (posix_spawn(&process_, pointers[0], &actions, nullptr, pointers.data(), environ) != 0) process_ = -1;
  posix_spawn_file_actions_destroy(&actions);
  if (on == On::terminal) {
    other_end_ = out[1];  // Stays open, because a terminal loses its settings when no process has it open.
  } else {
    close(out[1]);
    close(in[0]);
  }
  close(err[1]);
  in_ = in[1];
  out_ = out[0];
  err_ = err[0];
}

ToolProcess::~ToolProcess() {
  if (process_ > 0) {
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
  }
  close_now(in_);
  close_now(out_);
  close_now(err_);
  close_now(other_end_);
}

bool ToolProcess::read_some() {
  std::array<pollfd, 2> readable{{{out_, POLLIN, 0}, {err_, POLLIN, 0}}};
  // The terminal stays open after the program has ended. By then all output of the program can be read from
  // the terminal.
  const bool may_end = err_ < 0 && out_ == terminal_;
  if (poll(readable.data(), readable.size(), may_end ? 0 : 60'000) <= 0) return false;
  std::array<char, 65536> part{};
  bool came = false;
  for (std::size_t i = 0; i < readable.size(); ++i) {
    if (readable[i].revents == 0) continue;
    const ssize_t bytes = read(readable[i].fd, part.data(), part.size());
    if (bytes > 0) (i == 0 ? ended_.out : ended_.err).append(part.data(), static_cast<std::size_t>(bytes));
    came = came || bytes > 0;
    if (bytes <= 0 && i == 0 && out_ != terminal_) close_now(out_);
    if (bytes <= 0 && i == 1) close_now(err_);
  }
  return came || (out_ >= 0 && out_ != terminal_) || err_ >= 0;
}

bool ToolProcess::prints(std::string_view expected) {
  while (ended_.out.find(expected) == std::string::npos) {
    if (!read_some()) return false;
  }
  return true;
}

bool ToolProcess::says(std::string_view expected) {
  while (ended_.err.find(expected) == std::string::npos) {
    if (err_ < 0 || !read_some()) return false;
  }
  return true;
}

void ToolProcess::press(std::string_view keys) const {
  if (write(terminal_, keys.data(), keys.size()) < 0) return;
}

void ToolProcess::feed(std::string_view text) const {
  while (!text.empty()) {
    const ssize_t bytes = ::send(in_, text.data(), text.size(), MSG_NOSIGNAL);
    if (bytes < 0) return;
    text.remove_prefix(static_cast<std::size_t>(bytes));
  }
}

void ToolProcess::end_input() { close_now(in_); }

void ToolProcess::send(int signal) const { kill(process_, signal); }

void ToolProcess::close_output() { close_now(out_); }

bool ToolProcess::echoes() const {
  termios settings{};
  tcgetattr(terminal_, &settings);
  return (settings.c_lflag & ECHO) != 0;
}

Ended ToolProcess::end() {
  while (read_some()) continue;
  int status = 0;
  while (waitpid(process_, &status, 0) < 0 && errno == EINTR) continue;
  process_ = -1;
  ended_.code = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  return ended_;
}

Ended run_tool(std::vector<std::string> arguments, std::string_view input) {
  ToolProcess tool(std::move(arguments));
  tool.feed(input);
  tool.end_input();
  return tool.end();
}

}  // namespace sft::test
