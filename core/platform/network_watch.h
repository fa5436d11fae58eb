// Notices that the host's interfaces, addresses or routes have changed: by a netlink socket (rtnetlink(7)),
// which costs nothing while they have not.
#pragma once

#include "core/platform/file_descriptor.h"

namespace sft::core {

class NetworkWatch {
 public:
  /// Of the network namespace of this thread.
  NetworkWatch();

  /// Whether anything may have changed since it was asked last; always where the system refuses the socket.
  bool changed() noexcept;

 private:
  FileDescriptor netlink_;
};

}  // namespace sft::core
