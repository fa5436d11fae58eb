// Detects changes of the host's interfaces, addresses or routes by a netlink socket (rtnetlink(7)). The
// socket costs nothing while there are no changes.
#pragma once

#include <cstdint>

#include "core/platform/file_descriptor.h"

namespace sft::core {

class NetworkMonitor {
 public:
  /// Begins to watch the network namespace of the calling thread.
  NetworkMonitor();

  /// Returns true if interfaces, addresses or routes may have changed since the last call. Always returns
  /// true if the system refuses the socket.
  bool changed() noexcept;
  /// Returns true if the program has closed the socket, and probably all other descriptors of this process.
  /// The number of the descriptor may now belong to another file.
  bool was_closed() const noexcept { return was_closed_; }
  /// Returns a number that grows when interfaces, addresses or routes may have changed. Use it if several
  /// users share a monitor; they must not call changed() then.
  std::uint64_t changes() noexcept {
    if (changed()) ++changes_;
    return changes_;
  }

 private:
  bool is_another_file() const noexcept;

  FileDescriptor netlink_;
  std::uint64_t inode_ = 0;  ///< the inode of the socket
  std::uint64_t changes_ = 0;
  bool was_closed_ = false;
};

}  // namespace sft::core
