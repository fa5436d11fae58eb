#include "shm_transport/sftd/detach.h"

#include <fcntl.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>

namespace sft::shm {

namespace {

void print(ExitCode code, const std::string& message) {
  if (message.empty()) return;
  std::fprintf(code == ExitCode::done ? stdout : stderr, "sftd: %s\n", message.c_str());
  std::fflush(nullptr);
}

[[noreturn]] void wait_for_result(int channel) {
  std::string text;
  char bytes[512];
  ssize_t size = 0;
  while ((size = read(channel, bytes, sizeof bytes)) > 0) text.append(bytes, static_cast<std::size_t>(size));
  if (text.empty()) {
    print(ExitCode::failed, "the daemon died while it started; is there space left in /dev/shm?");
    _exit(static_cast<int>(ExitCode::failed));
  }
  const auto code = static_cast<ExitCode>(text.front());
  print(code, text.substr(1));
  _exit(static_cast<int>(code));
}

/// Moves this descriptor to the first number after the standard descriptors, and closes all other
/// descriptors that the shell or a parent left open.
int keep_only(int descriptor) {
  constexpr int first_free = 3;
  if (descriptor != first_free) dup3(descriptor, first_free, O_CLOEXEC);
  close_range(first_free + 1, ~0U, 0);
  return first_free;
}

void leave_terminal() {
  setsid();
  if (const pid_t child = fork(); child != 0) _exit(0);  // only the leader of a session can get a terminal
  if (chdir("/") != 0) return;
  const int null = open("/dev/null", O_RDWR | O_CLOEXEC);
  for (int stream = 0; stream < 3 && null >= 0; ++stream) dup2(null, stream);
  close(null);
}

}  // namespace

Starter Starter::detach() {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return in_foreground();
  const pid_t child = fork();
  if (child < 0) return in_foreground();
  if (child > 0) {
    close(ends[1]);
    wait_for_result(ends[0]);
  }
  const int channel = keep_only(ends[1]);
  leave_terminal();
  return Starter(Descriptor(channel));
}

void Starter::report(ExitCode code, const std::string& message) {
  if (!channel_) return print(code, message);
  const std::string text = static_cast<char>(code) + message;
  if (write(channel_.get(), text.data(), text.size()) < 0) return;  // fails if the waiting process was killed
  channel_ = Descriptor();
}

}  // namespace sft::shm
