// Notices that the host's interfaces, addresses or routes have changed: by a netlink socket (rtnetlink(7)),
// which costs nothing while they have not.
#pragma once

#include "core/platform/file_descriptor.h"

namespace sft::core {

class NetworkWatch {
 public:
  /// Watches the network namespace of the calling thread.
  NetworkWatch();

  /// Returns true if anything may have changed since the last call. Always returns true if the system refuses
  /// the socket.
  bool changed() noexcept;

 private:
  FileDescriptor netlink_;
};

}  // namespace sft::core
