// Makes the address of a Unix domain socket that has a path.
#pragma once

#include <sys/socket.h>
#include <sys/un.h>

#include <cstring>
#include <string>

namespace sft::shm {

/// Returns the address of the path. A path that is too long for an address is cut off.
inline sockaddr_un socket_address(const std::string& path) noexcept {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
  return address;
}

}  // namespace sft::shm
