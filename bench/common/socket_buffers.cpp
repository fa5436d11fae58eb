// Gives the sockets of all contenders the buffer sizes that they request, as on a host whose administrator
// has raised net.core.rmem_max and wmem_max. Otherwise, a contender without SO_RCVBUFFORCE would be
// measured with the limit of this machine.
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace {

int forced(int level, int option) {
  if (level == SOL_SOCKET && option == SO_RCVBUF) return SO_RCVBUFFORCE;
  if (level == SOL_SOCKET && option == SO_SNDBUF) return SO_SNDBUFFORCE;
  return option;
}

}  // namespace

/// Replaces the function of libc, even for calls from shared libraries.
extern "C" int setsockopt(int socket, int level, int option, const void* value, socklen_t bytes) noexcept {
  if (syscall(SYS_setsockopt, socket, level, forced(level, option), value, bytes) == 0) return 0;
  return static_cast<int>(syscall(SYS_setsockopt, socket, level, option, value, bytes));
}
