#include "udp_transport/io/socket_settings.h"

#include <sys/socket.h>

#include <algorithm>
#include <climits>

namespace sft::udp {

namespace {

/// Requests half of the size, because the kernel doubles the value. Only privileged processes get more than
/// the system's limit.
void set_buffer(int fd, int force_name, int name, std::size_t bytes) {
  const int half = static_cast<int>(std::min<std::size_t>(bytes / 2, INT_MAX / 2));
  if (bytes != 0 && !set_int(fd, SOL_SOCKET, force_name, half)) set_int(fd, SOL_SOCKET, name, half);
}

}  // namespace

bool set_int(int fd, int level, int name, int value) {
  return ::setsockopt(fd, level, name, &value, sizeof value) == 0;
}

void set_receive_buffer(int fd, std::size_t bytes) { set_buffer(fd, SO_RCVBUFFORCE, SO_RCVBUF, bytes); }

void set_send_buffer(int fd, std::size_t bytes) { set_buffer(fd, SO_SNDBUFFORCE, SO_SNDBUF, bytes); }

}  // namespace sft::udp
