// Notices that the host's interfaces, addresses or routes have changed: by a netlink socket (rtnetlink(7)),
// which costs nothing while they have not.
#pragma once

#include <cstdint>

#include "core/platform/file_descriptor.h"

namespace sft::core {

class NetworkMonitor {
 public:
  /// Watches the network namespace of the calling thread.
  NetworkMonitor();

  /// Returns true if anything may have changed since the last call. Always returns true if the system refuses
  /// the socket.
  bool changed() noexcept;
  /// True if the program has closed the socket, and with it probably all descriptors of this process. Its
  /// number may be that of another file by now.
  bool was_closed() const noexcept { return was_closed_; }
  /// For several who share a watch, and call nothing else: a number that has risen if anything may have
  /// changed.
  std::uint64_t changes() noexcept {
    if (changed()) ++changes_;
    return changes_;
  }

 private:
  bool is_another_file() const noexcept;

  FileDescriptor netlink_;
  std::uint64_t inode_ = 0;  ///< of the socket
  std::uint64_t changes_ = 0;
  bool was_closed_ = false;
};

}  // namespace sft::core
