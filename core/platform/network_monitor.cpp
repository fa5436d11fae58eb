#include "core/platform/network_monitor.h"

#include <linux/rtnetlink.h>
#include <sys/socket.h>
#include <sys/stat.h>

#include <cerrno>

namespace sft::core {

NetworkMonitor::NetworkMonitor()
    : netlink_(::socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, NETLINK_ROUTE)) {
  sockaddr_nl groups{};
  groups.nl_family = AF_NETLINK;
  groups.nl_groups =
      RTMGRP_LINK | RTMGRP_IPV4_IFADDR | RTMGRP_IPV4_ROUTE | RTMGRP_IPV6_IFADDR | RTMGRP_IPV6_ROUTE;
  if (::bind(netlink_.get(), reinterpret_cast<const sockaddr*>(&groups), sizeof groups) != 0) netlink_ = {};
  struct stat file {};
  if (netlink_ && ::fstat(netlink_.get(), &file) == 0) inode_ = file.st_ino;
}

bool NetworkMonitor::is_another_file() const noexcept {
  struct stat file {};
  return ::fstat(netlink_.get(), &file) != 0 || file.st_ino != inode_;
}

/// Removes the messages from the socket without reading their contents. Callers find out by other means
/// what has changed.
bool NetworkMonitor::changed() noexcept {
  if (!netlink_) return true;
  was_closed_ = is_another_file();
  if (was_closed_) return true;
  for (bool any = false;; any = true) {
    char start_of_message = 0;
    const bool came = ::recv(netlink_.get(), &start_of_message, sizeof start_of_message, 0) >= 0;
    // ENOBUFS means that the socket has lost messages.
    if (!came && errno != ENOBUFS && errno != EINTR) return any;
  }
}

}  // namespace sft::core
